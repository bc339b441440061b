// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds whose body is known: that bodies stay bodies, that doubt is said, that what shows no body is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "minimum_boundary/minimum_boundary.hpp"
#include "support/known_bodies.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using Parameters = MinimumBoundaryParameters;
using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

Result<MinimumBoundaryResult> try_reconstruct(const std::vector<Point3>& points, const Parameters& parameters = {}) {
  Context context(2);
  return minimum_boundary(*make_cloud(testing::raw_cloud(points)), parameters, context);
}

MinimumBoundaryResult reconstruct(const std::vector<Point3>& points, const Parameters& parameters = {}) {
  return *try_reconstruct(points, parameters);
}

double volume_share(const testing::KnownBody& body, std::size_t n, double noise, std::uint32_t seed) {
  return testing::volume_of(reconstruct(testing::points_of(body, n, noise, seed)).mesh) / body.volume;
}

/// Turned by the same odd angles everywhere, and rounded to float32 if asked for.
std::vector<Point3> tilted(const std::vector<Point3>& points, double angle, bool rounded) {
  std::vector<Point3> turned;
  for (const Point3& p : points) {
    const Point3 q{std::cos(angle) * p[0] - std::sin(angle) * p[2], p[1],
                   std::sin(angle) * p[0] + std::cos(angle) * p[2]};
    const double other = 2.3 * angle;
    Point3 r{q[0], std::cos(other) * q[1] - std::sin(other) * q[2], std::sin(other) * q[1] + std::cos(other) * q[2]};
    if (rounded) {
      for (double& x : r) x = static_cast<double>(static_cast<float>(x));
    }
    turned.push_back(r);
  }
  return turned;
}

/// A grid of side x side points in the plane z = 0, moved off it by up to `noise`.
std::vector<Point3> sheet(std::size_t side, double noise, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Point3> points;
  for (std::size_t i = 0; i < side; ++i) {
    for (std::size_t j = 0; j < side; ++j) {
      points.push_back({static_cast<double>(i) / static_cast<double>(side),
                        static_cast<double>(j) / static_cast<double>(side),
                        noise * (2 * testing::random_unit(random) - 1)});
    }
  }
  return points;
}

TEST(Flatness, sheets_are_refused_at_every_tilt_up_to_rounding_and_up_to_noise) {
  for (const double angle : {0.0, 0.1, 0.4, 0.7, 1.0, 1.3, 1.57}) {
    for (const std::size_t side : {3U, 15U}) {
      for (const double noise : {0.0, 1e-12, 1e-4}) {
        for (const bool rounded : {false, true}) {
          const auto result = try_reconstruct(tilted(sheet(side, noise, 7), angle, rounded));
          ASSERT_FALSE(result) << angle << ' ' << side << ' ' << noise << ' ' << rounded;
          EXPECT_EQ(result.error().code, ErrorCode::coplanar) << angle << ' ' << side << ' ' << noise << ' ' << rounded;
          EXPECT_THAT(result.error().detail, ::testing::HasSubstr(std::to_string(side * side) + " distinct point"));
        }
      }
    }
  }
}

TEST(Flatness, rows_are_refused_at_every_tilt) {
  for (const double angle : {0.0, 0.3, 0.9, 1.4}) {
    for (const double noise : {0.0, 1e-9}) {
      std::mt19937 random(3);
      std::vector<Point3> row;
      for (int k = 0; k < 50; ++k) {
        row.push_back({0.02 * k, noise * testing::random_unit(random), noise * testing::random_unit(random)});
      }
      const auto result = try_reconstruct(tilted(row, angle, true));
      ASSERT_FALSE(result);
      EXPECT_EQ(result.error().code, ErrorCode::collinear) << angle << ' ' << noise << ' ' << result.error().detail;
    }
  }
}

TEST(Flatness, thin_bodies_and_few_points_are_no_sheets) {
  std::vector<Point3> corners;
  for (const double x : {0.0, 1.0}) {
    for (const double y : {0.0, 1.0}) {
      for (const double z : {0.0, 0.001}) corners.push_back({x, y, z});
    }
  }
  EXPECT_NEAR(testing::volume_of(reconstruct(tilted(corners, 0.4, false)).mesh), 0.001, 1e-9);
  EXPECT_TRUE(try_reconstruct({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 0.01}}));
  std::vector<Point3> both = sheet(20, 0, 1);
  for (Point3 p : sheet(20, 0, 1)) {
    p[2] = 0.02;
    both.push_back(p);
  }
  EXPECT_TRUE(try_reconstruct(tilted(both, 0.7, true)));
}

TEST(KnownBodies, noisy_points_of_a_body_do_not_end_as_a_hollow_cage) {
  bool dense = false;
  for (const testing::KnownBody& body : testing::known_bodies()) {
    if (body.name == "knot") continue;
    dense = !dense;
    const std::size_t n = dense ? 600 : 400;
    const double noise = dense ? 0.35 : 0.2;
    EXPECT_NEAR(volume_share(body, n, noise, 101), 1, 0.25) << body.name << ", " << n << " points, noise " << noise;
  }
}

/// Random points of the torus, none nearer to another than the distance, until many in a row do not fit.
std::vector<Point3> poisson_disk_torus(double tube, double distance, std::uint32_t seed) {
  std::mt19937 random(seed);
  const testing::KnownBody body = testing::torus_body("torus", tube);
  std::vector<Point3> points;
  for (int misses = 0; misses < 3000;) {
    const Point3 p = body.point(random);
    const bool fits = std::ranges::all_of(points, [&](const Point3& q) { return norm(p - q) >= distance; });
    misses = fits ? 0 : misses + 1;
    if (fits) points.push_back(p);
  }
  return points;
}

TEST(Handles, that_most_labellings_agree_on_stay) {
  int kept = 0;
  int silent = 0;
  for (const double factor : {1.2, 1.3}) {
    for (std::uint32_t seed = 0; seed < 5; ++seed) {
      const auto result = reconstruct(poisson_disk_torus(0.3, 0.3 * factor, seed));
      if (result.statistics.genus == 1) {
        ++kept;
      } else if (result.warnings.empty()) {
        ++silent;
      }
    }
  }
  EXPECT_GE(kept, 8);
  EXPECT_EQ(silent, 0);
}

std::vector<Point3> balls(std::size_t count, std::size_t n, double gap) {
  std::vector<Point3> points;
  const double spacing = std::sqrt(4 * std::numbers::pi / static_cast<double>(n));
  for (std::size_t k = 0; k < count; ++k) {
    const auto more = testing::sphere_points(n, {static_cast<double>(k) * (2 + gap * spacing), 0, 0});
    points.insert(points.end(), more.begin(), more.end());
  }
  return points;
}

TEST(Components, auto_makes_a_body_of_every_part_that_only_a_bridge_would_join) {
  for (const std::size_t count : {2U, 4U}) {
    for (const double gap : {2.0, 5.0, 40.0}) {
      const auto result = reconstruct(balls(count, 500, gap));
      EXPECT_EQ(result.statistics.components, count) << gap;
      EXPECT_EQ(result.statistics.bodies, count) << gap;
      EXPECT_EQ(result.statistics.genus, 0) << gap;
      EXPECT_THAT(result.warnings, IsEmpty()) << gap;
      const auto one = reconstruct(balls(count, 500, gap), {.components = Parameters::Components::one});
      EXPECT_EQ(one.statistics.components, 1U);
      EXPECT_THAT(one.warnings, Contains(StartsWith("components_joined"))) << gap;
    }
  }
}

TEST(Components, auto_keeps_nested_shells_and_one_body_as_it_is) {
  std::vector<Point3> points = testing::sphere_points(1500);
  EXPECT_EQ(reconstruct(points).statistics.bodies, 1U);
  const auto inner = testing::sphere_points(500, {0, 0, 0}, 0.5);
  points.insert(points.end(), inner.begin(), inner.end());
  const auto hollow = reconstruct(points);
  EXPECT_EQ(hollow.statistics.components, 2U);
  EXPECT_NEAR(signed_volume(hollow.mesh), 4 * std::numbers::pi / 3 * (1 - 0.125), 0.05);
}

TEST(Doubt, a_far_point_makes_a_spike_with_a_warning_that_names_the_remedy) {
  std::vector<Point3> points = testing::sphere_points(1000);
  EXPECT_THAT(reconstruct(points).warnings, IsEmpty());
  points.push_back({3, 0.1, 0.2});
  const auto result = reconstruct(points);
  EXPECT_EQ(result.statistics.outliers, 1U);
  EXPECT_THAT(result.warnings,
              Contains(::testing::AllOf(StartsWith("outliers_suspected"), ::testing::HasSubstr("outliers="))));
}

TEST(Doubt, bodies_given_by_their_corners_alone_are_said_to_be_undersampled) {
  constexpr std::array<std::array<double, 2>, 8> kProfile{
      {{0, 0}, {30, 0}, {30, 30}, {20, 30}, {20, 10}, {10, 10}, {10, 30}, {0, 30}}};
  std::vector<Point3> corners;
  for (const auto& [x, y] : kProfile) {
    for (const double z : {0.0, 10.0}) corners.push_back({x, y, z});
  }
  EXPECT_THAT(reconstruct(corners).warnings, Contains(StartsWith("sampling_uncertain")));
  EXPECT_THAT(reconstruct(testing::torus_points(30, 12)).warnings, Not(Contains(StartsWith("sampling_uncertain"))));
}

TEST(Doubt, is_small_for_a_dense_body_and_large_where_the_points_hardly_show_a_handle) {
  const auto dense = reconstruct(testing::random_torus(3000, 5));
  ASSERT_TRUE(dense.statistics.doubt);
  EXPECT_LT(*dense.statistics.doubt, 0.1);
  EXPECT_TRUE(dense.statistics.evidence->guide_agrees);
  EXPECT_LT(dense.statistics.evidence->opposed_triangles, 0.01);
  double sum = 0;
  for (std::uint32_t seed = 0; seed < 10; ++seed) sum += *reconstruct(testing::random_torus(60, seed)).statistics.doubt;
  EXPECT_GT(sum / 10, 0.2);
}

TEST(Doubt, sees_triangles_that_web_two_sheets_by_the_normals_of_the_guiding_surface) {
  std::vector<Point3> points = testing::sphere_points(800);
  const auto one = reconstruct(points).statistics.evidence;
  std::erase_if(points, [](const Point3& p) { return std::abs(p[2]) < 0.35; });
  const auto cut = reconstruct(points).statistics.evidence;
  ASSERT_TRUE(one && cut);
  EXPECT_EQ(one->opposed_triangles, 0);
  EXPECT_GT(one->guide_shared, 0.9);
  EXPECT_LT(cut->guide_shared, one->guide_shared);
}

TEST(Candidates, a_large_cloud_needs_two_where_they_agree) {
  EXPECT_EQ(reconstruct(testing::random_torus(6000, 3)).statistics.candidates.size(), 2U);
  std::vector<Point3> noisy = testing::random_torus(6000, 3);
  std::mt19937 random(4);
  for (Point3& p : noisy) {
    for (double& x : p) x += 0.02 * testing::random_normal(random);
  }
  EXPECT_GE(reconstruct(noisy).statistics.candidates.size(), 5U);
}

TEST(Candidates, are_the_same_for_any_number_of_threads) {
  const std::vector<Point3> points = testing::random_torus(6000, 8);
  const PointCloud cloud = *make_cloud(testing::raw_cloud(points));
  Context alone(1);
  Context four(4);
  const auto expected = minimum_boundary(cloud, {}, alone);
  const auto result = minimum_boundary(cloud, {}, four);
  ASSERT_TRUE(expected && result);
  EXPECT_EQ(result->mesh.triangles, expected->mesh.triangles);
  EXPECT_EQ(result->statistics.doubt, expected->statistics.doubt);
}

TEST(Doubt, points_inside_are_counted_in_a_warning) {
  std::vector<Point3> points = testing::sphere_points(400);
  for (const Point3& p : testing::random_points(40, 9)) points.push_back({0.3 * p[0], 0.3 * p[1], 0.3 * p[2]});
  const auto result = reconstruct(points, {.lids = Parameters::Lids::mincut, .variant = Parameters::Variant::paper});
  const bool many = result.statistics.interior_vertices > 2;
  EXPECT_EQ(std::ranges::any_of(result.warnings, [](const std::string& w) { return w.starts_with("points_inside"); }),
            many);
}

TEST(Sampling, epsilon_falls_with_the_spacing_and_is_above_one_at_the_corners_of_a_box) {
  const auto coarse = reconstruct(testing::torus_points(30, 12)).statistics.sampling;
  const auto fine = reconstruct(testing::torus_points(90, 36)).statistics.sampling;
  ASSERT_TRUE(coarse && fine);
  EXPECT_NEAR(coarse->median / fine->median, 3, 0.6);
  EXPECT_LT(fine->high, 0.5);
  std::vector<Point3> corners;
  for (const double x : {0.0, 1.0}) {
    for (const double y : {0.0, 1.0}) {
      for (const double z : {0.0, 1.0}) corners.push_back({x, y, z});
    }
  }
  EXPECT_GT(reconstruct(corners).statistics.sampling->median, 0.8);
}

TEST(Openings, are_cut_out_of_a_scan_without_a_bottom_and_of_nothing_closed) {
  std::vector<Point3> points = testing::sphere_points(3000);
  const auto closed = reconstruct(points, {.openings = Parameters::Openings::keep});
  EXPECT_TRUE(topology_of(closed.mesh).closed);
  EXPECT_EQ(closed.statistics.opened_triangles, 0U);
  std::erase_if(points, [](const Point3& p) { return p[2] > 0.3; });
  const auto open = reconstruct(points, {.openings = Parameters::Openings::keep});
  const Topology topology = topology_of(open.mesh);
  EXPECT_FALSE(topology.closed);
  EXPECT_TRUE(topology.edge_manifold && topology.vertex_manifold && topology.oriented);
  EXPECT_EQ(topology.boundary_loops, 1U);
  EXPECT_EQ(topology.components, 1U);
  EXPECT_GT(open.statistics.opened_triangles, 0U);
  std::vector<bool> used(points.size(), false);
  for (const Triangle& t : open.mesh.triangles) {
    for (const VertexIndex v : t) used[v] = true;
  }
  EXPECT_EQ(std::ranges::count(used, false), 0);
}

/// The triangles by the places of their corners, each sorted, all sorted.
std::vector<std::array<Point3, 3>> places_of(const TriangleMesh& mesh) {
  std::vector<std::array<Point3, 3>> places;
  for (const Triangle& t : mesh.triangles) {
    std::array<Point3, 3> corners{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
    std::ranges::sort(corners);
    places.push_back(corners);
  }
  std::ranges::sort(places);
  return places;
}

TEST(Invariance, the_boundary_complex_is_the_same_for_mirrored_and_permuted_axes) {
  const std::vector<Point3> points = testing::random_torus(800, 12);
  const Parameters parameters{.stop_after = Parameters::StopAfter::boundary_complex};
  const auto expected = places_of(reconstruct(points, parameters).mesh);
  std::vector<Point3> turned;
  for (const Point3& p : points) turned.push_back({-p[2], p[0], -p[1]});
  TriangleMesh back = reconstruct(turned, parameters).mesh;
  for (Point3& p : back.positions) p = {p[1], -p[2], -p[0]};
  EXPECT_EQ(places_of(back), expected);
}

}  // namespace
}  // namespace surfaced
