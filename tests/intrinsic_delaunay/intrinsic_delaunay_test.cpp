#include "intrinsic_delaunay/intrinsic_delaunay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>

#include "support/manifolds.hpp"
#include "support/nasty_clouds.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using Parameters = IntrinsicDelaunayParameters;

Result<IntrinsicDelaunayResult> reconstruct(const std::vector<Point3>& points, const Parameters& parameters = {},
                                            unsigned threads = 1) {
  Context context(threads);
  return intrinsic_delaunay(*make_cloud(testing::raw_cloud(points)), parameters, context);
}

std::vector<Parameters> variants() {
  std::vector<Parameters> all(1);
  all.push_back({.epsilon = 0.2});
  all.push_back({.max_edge = 1.5});
  all.push_back({.epsilon = 1e-3, .fill_holes = Parameters::FillHoles::none});
  all.push_back({.max_edge = 1e6});
  return all;
}

/// What is promised of every mesh.
void expect_manifold(const IntrinsicDelaunayResult& result, const std::string& name) {
  testing::expect_oriented_manifold(result.mesh, name);
  EXPECT_EQ(topology_of(result.mesh).boundary_edges, result.statistics.front.open_edges) << name;
}

TEST(IntrinsicDelaunay, finds_sphere_and_torus_also_where_the_points_are_random) {
  const auto sphere = reconstruct(testing::sphere_points(3000));
  ASSERT_TRUE(sphere);
  EXPECT_TRUE(topology_of(sphere->mesh).closed);
  EXPECT_EQ(topology_of(sphere->mesh).genus, 0);
  EXPECT_GT(signed_volume(sphere->mesh), 4.1);
  for (const auto& points : {testing::torus_points(60, 24), testing::random_torus(8000, 1)}) {
    const auto torus = reconstruct(points);
    ASSERT_TRUE(torus);
    const Topology topology = topology_of(torus->mesh);
    EXPECT_TRUE(topology.closed);
    EXPECT_EQ(topology.genus, 1);
    EXPECT_EQ(topology.vertices, points.size());
  }
}

TEST(IntrinsicDelaunay, epsilon_bounds_how_far_a_face_reaches_from_the_edge_it_was_made_at) {
  const auto points = testing::random_torus(4000, 6);
  constexpr double kEpsilon = 0.02;
  const auto result = reconstruct(points, {.epsilon = kEpsilon, .fill_holes = Parameters::FillHoles::none});
  ASSERT_TRUE(result);
  expect_manifold(*result, "small epsilon");
  EXPECT_GT(result->statistics.front.open_edges, 0U);
  // The height over the longest edge is the least distance of a vertex from the opposite edge. Flips and points
  // inserted later keep within what was there.
  std::size_t higher = 0;
  for (const Triangle& t : result->mesh.triangles) {
    const Point3& a = result->mesh.positions[t[0]];
    const Point3 n = cross(result->mesh.positions[t[1]] - a, result->mesh.positions[t[2]] - a);
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(longest, norm(result->mesh.positions[t[(i + 1) % 3]] - result->mesh.positions[t[i]]));
    if (norm(n) / longest > 2 * kEpsilon) ++higher;
  }
  EXPECT_EQ(higher, 0U);
}

TEST(IntrinsicDelaunay, max_edge_bounds_every_edge) {
  auto points = testing::sphere_points(4000);
  std::erase_if(points, [](const Point3& p) { return p[2] > 0.96; });
  for (const std::optional<double> limit : {std::optional<double>(), std::optional<double>(2.5)}) {
    const auto result = reconstruct(points, {.max_edge = limit});
    ASSERT_TRUE(result);
    const Topology topology = topology_of(result->mesh);
    EXPECT_EQ(topology.boundary_loops, 1U) << "the opening stays open";
    EXPECT_EQ(topology.vertices, points.size());
  }
}

TEST(IntrinsicDelaunay, the_smallest_inputs_give_what_there_is) {
  const auto triangle = reconstruct({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  ASSERT_TRUE(triangle);
  EXPECT_EQ(triangle->mesh.triangles.size(), 1U);
  const auto square = reconstruct({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
  ASSERT_TRUE(square);
  EXPECT_EQ(square->mesh.triangles.size(), 2U);
  std::vector<Point3> cube;
  for (int i = 0; i < 8; ++i) cube.push_back({1.0 * (i & 1), 1.0 * (i >> 1 & 1), 1.0 * (i >> 2)});
  const auto corners = reconstruct(cube);
  ASSERT_TRUE(corners);
  expect_manifold(*corners, "cube");
  EXPECT_FALSE(corners->mesh.triangles.empty());
}

TEST(IntrinsicDelaunay, refuses_too_few_points_and_points_on_a_line_with_typed_errors) {
  EXPECT_EQ(reconstruct({}).error().code, ErrorCode::too_few_points);
  EXPECT_EQ(reconstruct({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}}).error().code, ErrorCode::too_few_points);
  EXPECT_THAT(reconstruct({{0, 0, 0}, {1, 0, 0}}).error().detail, ::testing::HasSubstr("intrinsic-delaunay needs 3"));
  std::vector<Point3> line;
  for (int i = 0; i < 100; ++i) line.push_back({1.0 * i, 2.0 * i, -3.0 * i});
  EXPECT_EQ(reconstruct(line).error().code, ErrorCode::collinear);
}

TEST(IntrinsicDelaunay, is_manifold_on_every_nasty_cloud_with_every_variant) {
  const auto all = variants();
  for (std::uint64_t number = 0; number < 2500; ++number) {
    const testing::NastyCloud nasty = testing::NastyClouds::make(number);
    const auto result = reconstruct(nasty.points, all[number / 11 % all.size()]);
    const std::string name = nasty.kind + " " + std::to_string(number);
    if (!result) {
      EXPECT_TRUE(result.error().code == ErrorCode::too_few_points || result.error().code == ErrorCode::collinear)
          << name;
      continue;
    }
    expect_manifold(*result, name);
  }
}

TEST(IntrinsicDelaunay, noise_neither_hangs_nor_explodes) {
  for (const double noise : {0.003, 0.01, 0.03, 0.1}) {
    const auto points = testing::random_torus(6000, 5, noise);
    for (const Parameters& parameters : variants()) {
      const auto result = reconstruct(points, parameters);
      ASSERT_TRUE(result);
      expect_manifold(*result, "noise " + std::to_string(noise));
      EXPECT_LE(result->mesh.triangles.size(), 2 * points.size());
    }
  }
  const auto cloud = testing::random_points(4000, 9);
  const auto result = reconstruct(cloud);
  ASSERT_TRUE(result);
  expect_manifold(*result, "points in a cube");
}

TEST(IntrinsicDelaunay, is_the_same_for_any_order_of_the_points_and_any_number_of_threads) {
  std::vector<Point3> points = testing::random_torus(9000, 2);
  const auto expected = reconstruct(points);
  std::mt19937 random(3);
  for (const unsigned threads : {1U, 2U, 4U}) {
    std::ranges::shuffle(points, random);
    const auto result = reconstruct(points, {}, threads);
    EXPECT_EQ(result->mesh.positions, expected->mesh.positions);
    EXPECT_EQ(result->mesh.triangles, expected->mesh.triangles);
  }
}

TEST(IntrinsicDelaunay, is_the_same_at_any_power_of_two_scale) {
  const std::vector<Point3> points = testing::random_torus(3000, 4);
  for (const std::optional<double> epsilon : {std::optional<double>(), std::optional<double>(0.05)}) {
    const auto expected = reconstruct(points, {.epsilon = epsilon});
    for (const double scale : {0x1p-70, 0x1p60}) {
      std::vector<Point3> scaled = points;
      for (Point3& p : scaled) {
        for (double& x : p) x *= scale;
      }
      Parameters parameters;
      if (epsilon) parameters.epsilon = *epsilon * scale;
      EXPECT_EQ(reconstruct(scaled, parameters)->mesh.triangles, expected->mesh.triangles);
    }
  }
}

TEST(IntrinsicDelaunay, can_be_cancelled_in_every_stage) {
  const PointCloud cloud = *make_cloud(testing::raw_cloud(testing::random_torus(5000, 7)));
  for (const std::string at : {"neighbourhoods", "consensus", "front", "holes", "flips"}) {
    std::atomic<bool> cancel{false};
    Context context(
        1, [&](double, std::string_view stage) { cancel = cancel || stage == at; }, &cancel);
    const auto result = intrinsic_delaunay(cloud, {}, context);
    ASSERT_FALSE(result) << at;
    EXPECT_EQ(result.error().code, ErrorCode::cancelled);
  }
}

}  // namespace
}  // namespace surfaced
