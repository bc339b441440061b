// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/minimum_boundary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <random>

#include "io/io.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using Parameters = MinimumBoundaryParameters;

MinimumBoundaryResult reconstruct(const std::vector<Point3>& points, const Parameters& parameters = {},
                                  unsigned threads = 1) {
  Context context(threads);
  return *minimum_boundary(*make_cloud(testing::raw_cloud(points)), parameters, context);
}

std::vector<Point3> random_torus(std::size_t n, std::uint32_t seed, double tube = 0.3) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
  std::vector<Point3> points;
  for (std::size_t i = 0; i < n; ++i) {
    const double u = angle(random);
    const double v = angle(random);
    points.push_back(
        {(1 + tube * std::cos(v)) * std::cos(u), (1 + tube * std::cos(v)) * std::sin(u), tube * std::sin(v)});
  }
  return points;
}

/// A head on shoulders, without its flat bottom: random points of a surface of revolution, bumpy.
std::vector<Point3> bust(std::size_t n, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Point3> points;
  while (points.size() < n) {
    const double z = 2.4 * unit(random);
    const double radius = z < 0.7    ? 0.95 - 0.4 * z * z
                          : z < 1.06 ? 0.754 - 1.1 * (z - 0.7)
                                     : std::sqrt(std::max(0.0, 0.49 - (z - 1.7) * (z - 1.7) * 1.0));
    if (unit(random) > radius) continue;
    const double angle = 2 * std::numbers::pi * unit(random);
    const double r = radius * (1 + 0.03 * std::sin(5 * angle) * std::sin(9 * z));
    points.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  return points;
}

TEST(MinimumBoundary, four_points_give_the_tetrahedron) {
  const auto result = reconstruct({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  EXPECT_EQ(result.mesh.triangles.size(), 4U);
  EXPECT_GT(signed_volume(result.mesh), 0);
}

TEST(MinimumBoundary, eight_corners_give_the_cube_with_the_shortest_diagonals) {
  std::vector<Point3> corners;
  for (int i = 0; i < 8; ++i) corners.push_back({1.0 * (i & 1), 1.0 * (i >> 1 & 1), 1.0 * (i >> 2)});
  const auto result = reconstruct(corners);
  EXPECT_EQ(result.mesh.triangles.size(), 12U);
  EXPECT_EQ(topology_of(result.mesh).genus, 0);
  EXPECT_NEAR(result.statistics.sum_lambda, 12 * std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(signed_volume(result.mesh), 1, 1e-12);
}

TEST(MinimumBoundary, interpolates_every_point_of_a_sphere) {
  const auto result = reconstruct(testing::sphere_points(2000));
  EXPECT_EQ(result.mesh.triangles.size(), 2 * 2000U - 4);
  EXPECT_EQ(topology_of(result.mesh).genus, 0);
  EXPECT_EQ(result.statistics.interior_vertices, 0U);
}

TEST(MinimumBoundary, finds_the_handle_of_a_torus_also_where_the_points_are_random) {
  for (const auto& points : {testing::torus_points(40, 18), random_torus(5000, 1)}) {
    const auto result = reconstruct(points);
    const Topology topology = topology_of(result.mesh);
    EXPECT_TRUE(topology.closed && topology.vertex_manifold && topology.oriented);
    EXPECT_EQ(topology.genus, 1);
    EXPECT_EQ(topology.components, 1U);
    EXPECT_EQ(result.statistics.interior_vertices, 0U);
    EXPECT_EQ(result.statistics.genus, 1);
  }
}

TEST(MinimumBoundary, is_the_same_for_any_order_of_the_points_and_any_number_of_threads) {
  std::vector<Point3> points = random_torus(6000, 2);
  const auto expected = reconstruct(points);
  std::mt19937 random(3);
  for (const unsigned threads : {1U, 2U, 4U}) {
    std::ranges::shuffle(points, random);
    const auto result = reconstruct(points, {}, threads);
    EXPECT_EQ(result.mesh.positions, expected.mesh.positions);
    EXPECT_EQ(result.mesh.triangles, expected.mesh.triangles);
  }
}

TEST(MinimumBoundary, is_the_same_at_any_power_of_two_scale) {
  const std::vector<Point3> points = random_torus(2000, 4);
  const auto expected = reconstruct(points);
  for (const double scale : {0x1p-70, 0x1p60}) {
    std::vector<Point3> scaled = points;
    for (Point3& p : scaled) {
      for (double& x : p) x *= scale;
    }
    const auto result = reconstruct(scaled);
    EXPECT_EQ(result.mesh.triangles, expected.mesh.triangles);
    EXPECT_NEAR(result.statistics.sum_lambda / scale, expected.statistics.sum_lambda,
                1e-9 * expected.statistics.sum_lambda);
  }
}

std::vector<Point3> two_spheres(std::size_t n, double distance) {
  std::vector<Point3> points = testing::sphere_points(n);
  const auto other = testing::sphere_points(n, {distance, 0, 0});
  points.insert(points.end(), other.begin(), other.end());
  return points;
}

TEST(MinimumBoundary,
     far_objects_stay_apart_when_many_are_welcome_and_are_joined_with_a_warning_when_one_is_asked_for) {
  for (const double distance : {6.0, 1e6}) {
    const auto points = two_spheres(2000, distance);
    const auto many = reconstruct(points, {.components = Parameters::Components::many});
    EXPECT_EQ(topology_of(many.mesh).components, 2U);
    EXPECT_EQ(topology_of(many.mesh).genus, 0);
    EXPECT_THAT(many.warnings, ::testing::IsEmpty());
    EXPECT_EQ(many.statistics.joined_parts, 2U);
    for (const auto variant : {Parameters::Variant::best, Parameters::Variant::fast, Parameters::Variant::paper}) {
      for (const auto lids : {Parameters::Lids::watershed, Parameters::Lids::mincut}) {
        const auto one =
            reconstruct(points, {.components = Parameters::Components::one, .lids = lids, .variant = variant});
        const Topology topology = topology_of(one.mesh);
        EXPECT_TRUE(topology.closed && topology.vertex_manifold && topology.oriented);
        EXPECT_THAT(one.warnings, ::testing::Contains(::testing::StartsWith(
                                      topology.components > 1 ? "components_remaining" : "components_joined")));
      }
    }
  }
}

TEST(MinimumBoundary, near_objects_are_joined_without_a_warning) {
  const auto one = reconstruct(two_spheres(300, 2.2));
  EXPECT_EQ(topology_of(one.mesh).components, 1U);
  EXPECT_THAT(one.warnings, ::testing::IsEmpty());
}

TEST(MinimumBoundary, nested_shells_are_components_of_their_own_when_many_are_welcome) {
  std::vector<Point3> points = testing::sphere_points(1500);
  const auto inner = testing::sphere_points(500, {0, 0, 0}, 0.5);
  points.insert(points.end(), inner.begin(), inner.end());
  const auto hollow = reconstruct(points, {.components = Parameters::Components::many});
  EXPECT_EQ(topology_of(hollow.mesh).components, 2U);
  EXPECT_EQ(hollow.statistics.interior_vertices, 0U);
  EXPECT_NEAR(signed_volume(hollow.mesh), 4 * std::numbers::pi / 3 * (1 - 0.125), 0.05);

  const auto core = testing::sphere_points(300, {0.05, 0, 0}, 0.2);
  points.insert(points.end(), core.begin(), core.end());
  const auto body_in_cavity = reconstruct(points, {.components = Parameters::Components::many});
  EXPECT_EQ(topology_of(body_in_cavity.mesh).components, 3U);
  EXPECT_EQ(topology_of(body_in_cavity.mesh).genus, 0);
  EXPECT_EQ(body_in_cavity.statistics.interior_vertices, 0U);
  EXPECT_NEAR(signed_volume(body_in_cavity.mesh), 4 * std::numbers::pi / 3 * (1 - 0.125 + 0.008), 0.05);
}

TEST(MinimumBoundary, nested_shells_become_one_closed_surface_when_one_is_asked_for) {
  std::vector<Point3> points = testing::sphere_points(1500);
  const auto inner = testing::sphere_points(500, {0, 0, 0}, 0.5);
  points.insert(points.end(), inner.begin(), inner.end());
  for (const auto variant : {Parameters::Variant::best, Parameters::Variant::fast, Parameters::Variant::paper}) {
    const auto result = reconstruct(points, {.components = Parameters::Components::one, .variant = variant});
    const Topology topology = topology_of(result.mesh);
    EXPECT_TRUE(topology.closed && topology.vertex_manifold && topology.oriented);
    const bool warned = std::ranges::any_of(result.warnings,
                                            [](const std::string& w) { return w.starts_with("components_remaining"); });
    EXPECT_EQ(topology.components > 1, warned);
  }
}

TEST(MinimumBoundary, refuses_what_has_no_volume_and_says_how_many_points_remain) {
  struct Case {
    std::vector<Point3> points;
    ErrorCode code;
    std::string detail;
  };
  std::vector<Point3> line;
  std::vector<Point3> plane;
  for (int i = 0; i < 20; ++i) {
    line.push_back({1.0 * (i % 10), 2.0 * (i % 10), 0});
    plane.push_back({1.0 * (i % 4), 1.0 * (i % 5), 3});
  }
  for (const Case& c :
       {Case{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {-0.0, 0, 0}}, ErrorCode::too_few_points, "3 "},
        Case{{{1, 1, 1}, {1, 1, 1}}, ErrorCode::too_few_points, "1 "}, Case{line, ErrorCode::collinear, "10 "},
        Case{plane, ErrorCode::coplanar, "20 "}}) {
    Context context;
    const auto result = minimum_boundary(*make_cloud(testing::raw_cloud(c.points)), {}, context);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, c.code);
    EXPECT_THAT(result.error().detail, ::testing::HasSubstr(c.detail + "distinct point"));
  }
}

TEST(MinimumBoundary, papers_own_way_gives_a_sphere_and_a_torus_their_topology) {
  for (const auto& [points, genus] :
       {std::pair{testing::sphere_points(400), 0}, std::pair{testing::torus_points(30, 14), 1}}) {
    const auto result = reconstruct(points, {.variant = Parameters::Variant::paper});
    EXPECT_EQ(topology_of(result.mesh).genus, genus);
    EXPECT_EQ(result.statistics.interior_vertices, 0U);
  }
}

TEST(MinimumBoundary, a_sphere_with_a_wide_opening_is_closed_with_a_warning) {
  std::vector<Point3> points = testing::sphere_points(4000);
  std::erase_if(points, [](const Point3& p) { return p[2] > 0.3; });
  const auto result = reconstruct(points);
  EXPECT_EQ(topology_of(result.mesh).genus, 0);
  EXPECT_THAT(result.warnings, ::testing::Contains(::testing::StartsWith("closure_uncertain")));
}

TEST(MinimumBoundary, knows_the_topology_of_the_shared_clouds_and_leaves_no_point_inside) {
  struct Known {
    std::string name;
    std::int64_t genus;
    std::size_t most_interior;
  };
  for (const Known& known :
       {Known{"bunny", 0, 0}, Known{"fandisk", 0, 0}, Known{"fertility", 4, 0}, Known{"elephant", 0, 0},
        Known{"octopus", 0, 0}, Known{"knight", 0, 0}, Known{"heart", 0, 0}, Known{"max_planck", 0, 1},
        Known{"igea", 0, 10}, Known{"anchor", 4, 10}}) {
    const std::string path = std::string(SURFACED_SHARED_DATA) + "/" + known.name + ".ply";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    const PointCloud cloud = *make_cloud(*read_cloud(path));
    Context context(2);
    const auto result = minimum_boundary(cloud, {}, context);
    ASSERT_TRUE(result) << known.name;
    const Topology topology = topology_of(result->mesh);
    EXPECT_TRUE(topology.closed && topology.vertex_manifold && topology.oriented) << known.name;
    EXPECT_EQ(topology.components, 1U) << known.name;
    EXPECT_EQ(topology.genus, known.genus) << known.name;
    EXPECT_LE(result->statistics.interior_vertices, known.most_interior) << known.name;
  }
}

TEST(MinimumBoundary, min_cut_closes_a_bust_without_bottom) {
  for (const auto variant : {Parameters::Variant::best, Parameters::Variant::paper}) {
    const auto result = reconstruct(bust(5000, 8), {.lids = Parameters::Lids::mincut, .variant = variant});
    const Topology topology = topology_of(result.mesh);
    EXPECT_TRUE(topology.closed && topology.vertex_manifold && topology.oriented);
    EXPECT_EQ(topology.components, 1U);
    EXPECT_LE(topology.genus, variant == Parameters::Variant::best ? 0 : 1);
    EXPECT_LE(result.statistics.interior_vertices, 20U);
    EXPECT_GT(result.statistics.lids, 0U);
    EXPECT_GT(result.statistics.seed_factor, 0);
    EXPECT_THAT(result.warnings, ::testing::Contains(::testing::StartsWith("closure_uncertain")));
  }
}

TEST(MinimumBoundary, min_cut_is_the_same_for_any_order_of_the_points_and_any_number_of_threads) {
  std::vector<Point3> points = bust(3000, 9);
  const Parameters parameters{.lids = Parameters::Lids::mincut};
  const auto expected = reconstruct(points, parameters);
  std::mt19937 random(10);
  std::ranges::shuffle(points, random);
  EXPECT_EQ(reconstruct(points, parameters, 2).mesh.triangles, expected.mesh.triangles);
}

TEST(MinimumBoundary, warns_that_closing_is_a_guess_on_scans_with_large_openings_and_not_on_closed_clouds) {
  struct Known {
    std::string name;
    bool open;
  };
  for (const Known& known :
       {Known{"face", true}, Known{"range_lato000", true}, Known{"milk", true}, Known{"bunny", false},
        Known{"fandisk", false}, Known{"fertility", false}, Known{"elephant", false}, Known{"octopus", false},
        Known{"knight", false}, Known{"heart", false}, Known{"max_planck", false}, Known{"anchor", false},
        Known{"chameleon", false}}) {
    const std::string path = std::string(SURFACED_SHARED_DATA) + "/" + known.name + ".ply";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    Context context(2);
    const auto result =
        minimum_boundary(*make_cloud(*read_cloud(path)), {.variant = Parameters::Variant::fast}, context);
    ASSERT_TRUE(result) << known.name;
    const auto warns = ::testing::Contains(::testing::StartsWith("closure_uncertain"));
    if (known.open) {
      EXPECT_THAT(result->warnings, warns) << known.name;
    } else {
      EXPECT_THAT(result->warnings, ::testing::Not(warns)) << known.name;
    }
  }
}

TEST(MinimumBoundary, min_cut_closes_open_scans) {
  for (const std::string name : {"face", "range_lato000"}) {
    const std::string path = std::string(SURFACED_SHARED_DATA) + "/" + name + ".ply";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    const PointCloud cloud = *make_cloud(*read_cloud(path));
    Context context(2);
    const auto result = minimum_boundary(cloud, {.lids = Parameters::Lids::mincut}, context);
    ASSERT_TRUE(result) << name;
    const Topology topology = topology_of(result->mesh);
    EXPECT_TRUE(topology.closed && topology.vertex_manifold && topology.oriented) << name;
    EXPECT_LE(result->statistics.interior_vertices, cloud.size() / 100) << name;
    EXPECT_THAT(result->warnings, ::testing::Contains(::testing::StartsWith("closure_uncertain"))) << name;
  }
}

TEST(MinimumBoundary, says_topology_uncertain_exactly_where_the_doubt_is_large) {
  std::size_t fired = 0;
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    const auto result = reconstruct(random_torus(80, seed, 0.5));
    const bool warned =
        std::ranges::any_of(result.warnings, [](const std::string& w) { return w.starts_with("topology_uncertain"); });
    EXPECT_EQ(warned, result.statistics.doubt.value_or(0) > 0.456);
    fired += warned ? 1 : 0;
  }
  EXPECT_GT(fired, 0U);
  EXPECT_LT(fired, 30U);
  for (const std::string& warning : reconstruct(random_torus(5000, 1)).warnings) {
    EXPECT_FALSE(warning.starts_with("topology_uncertain")) << warning;
  }
}

TEST(MinimumBoundary, reports_how_much_curvature_edge_flips_could_remove_except_where_time_matters_most) {
  const auto points = random_torus(800, 11);
  for (const auto variant : {Parameters::Variant::best, Parameters::Variant::paper}) {
    const auto reduction = reconstruct(points, {.variant = variant}).statistics.curvature_reduction;
    ASSERT_TRUE(reduction);
    EXPECT_GT(*reduction, 0);
    EXPECT_LT(*reduction, 100);
  }
  EXPECT_FALSE(reconstruct(points, {.variant = Parameters::Variant::fast}).statistics.curvature_reduction);
}

TEST(MinimumBoundary, stops_after_the_boundary_complex_on_request) {
  const auto result = reconstruct(random_torus(1000, 5), {.stop_after = Parameters::StopAfter::boundary_complex});
  EXPECT_EQ(result.mesh.triangles.size(), result.statistics.boundary_complex_facets);
  EXPECT_EQ(topology_of(result.mesh).boundary_edges, 0U);
}

TEST(MinimumBoundary, reports_progress_that_never_falls_and_stages_without_gaps) {
  double last = 0;
  bool falls = false;
  Context context(2, [&](double fraction, std::string_view) {
    falls |= fraction < last;
    last = fraction;
  });
  ASSERT_TRUE(minimum_boundary(*make_cloud(testing::raw_cloud(random_torus(3000, 6))),
                               {.variant = Parameters::Variant::fast}, context));
  EXPECT_FALSE(falls);
  std::vector<std::string> names;
  for (const Stage& stage : context.finish()) names.push_back(stage.name);
  EXPECT_THAT(names,
              ::testing::IsSupersetOf({"delaunay", "flatten", "boundary-complex", "watershed", "inflate", "descent"}));
}

TEST(MinimumBoundary, can_be_cancelled_in_every_stage) {
  const PointCloud cloud = *make_cloud(testing::raw_cloud(random_torus(3000, 7)));
  std::vector<std::string> stages;
  {
    Context context(1, [&](double, std::string_view stage) {
      if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
    });
    ASSERT_TRUE(minimum_boundary(cloud, {}, context));
  }
  std::size_t cancelled = 0;
  for (const std::string& last : stages) {
    std::atomic<bool> cancel{false};
    Context context(
        1, [&](double, std::string_view stage) { cancel = cancel || stage == last; }, &cancel);
    const auto result = minimum_boundary(cloud, {}, context);
    if (result) continue;
    EXPECT_EQ(result.error().code, ErrorCode::cancelled);
    ++cancelled;
  }
  EXPECT_EQ(cancelled, stages.size());
}

}  // namespace
}  // namespace surfaced
