#include "local_delaunay/local_delaunay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>

#include "base/lanes.hpp"
#include "support/manifolds.hpp"
#include "support/nasty_clouds.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using Parameters = LocalDelaunayParameters;

Result<LocalDelaunayResult> reconstruct(const std::vector<Point3>& points, const Parameters& parameters = {},
                                        unsigned threads = 1) {
  Context context(threads);
  return local_delaunay(*make_cloud(testing::raw_cloud(points)), parameters, context);
}

std::vector<Parameters> variants() {
  std::vector<Parameters> all(1);
  all.push_back({.star = Parameters::Star::unfolded});
  all.push_back({.star = Parameters::Star::projected, .angle = Parameters::Angle::projected});
  all.push_back({.seed = Parameters::Seed::paper});
  all.push_back({.neighbours = 8, .max_edge = 3});
  all.push_back({.neighbours = 32, .fill_holes = Parameters::FillHoles::none});
  return all;
}

/// What is promised of every mesh.
void expect_manifold(const LocalDelaunayResult& result, const std::string& name) {
  testing::expect_oriented_manifold(result.mesh, name);
  EXPECT_EQ(topology_of(result.mesh).boundary_edges, result.statistics.open_edges) << name;
}

TEST(LocalDelaunay, interpolates_every_point_of_a_sphere_and_faces_outwards) {
  for (const Parameters& parameters : variants()) {
    const auto result = reconstruct(testing::sphere_points(3000), parameters);
    ASSERT_TRUE(result);
    const Topology topology = topology_of(result->mesh);
    EXPECT_EQ(topology.vertices, 3000U);
    EXPECT_EQ(topology.genus, 0);
    EXPECT_TRUE(topology.closed);
    EXPECT_GT(signed_volume(result->mesh), 4.1);
  }
}

TEST(LocalDelaunay, finds_the_handle_of_a_torus_also_where_the_points_are_random) {
  for (const auto& points : {testing::torus_points(60, 24), testing::random_torus(8000, 1)}) {
    const auto result = reconstruct(points);
    ASSERT_TRUE(result);
    const Topology topology = topology_of(result->mesh);
    EXPECT_TRUE(topology.closed);
    EXPECT_EQ(topology.genus, 1);
    EXPECT_EQ(topology.vertices, points.size());
  }
}

TEST(LocalDelaunay, two_spheres_stay_two) {
  auto points = testing::sphere_points(500);
  const auto other = testing::sphere_points(700, {4, 0, 0});
  points.insert(points.end(), other.begin(), other.end());
  const auto result = reconstruct(points);
  ASSERT_TRUE(result);
  const Topology topology = topology_of(result->mesh);
  EXPECT_EQ(topology.components, 2U);
  EXPECT_TRUE(topology.closed);
  EXPECT_EQ(topology.genus, 0);
}

TEST(LocalDelaunay, the_smallest_inputs_give_what_there_is) {
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
  EXPECT_EQ(corners->mesh.triangles.size(), 12U);
  EXPECT_NEAR(signed_volume(corners->mesh), 1, 1e-12);
  const auto tetrahedron = reconstruct({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  ASSERT_TRUE(tetrahedron);
  EXPECT_FALSE(tetrahedron->mesh.triangles.empty());
}

TEST(LocalDelaunay, refuses_too_few_points_and_points_on_a_line_with_typed_errors) {
  EXPECT_EQ(reconstruct({}).error().code, ErrorCode::too_few_points);
  EXPECT_EQ(reconstruct({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}}).error().code, ErrorCode::too_few_points);
  std::vector<Point3> line;
  for (int i = 0; i < 100; ++i) line.push_back({1.0 * i, 2.0 * i, -3.0 * i});
  EXPECT_EQ(reconstruct(line).error().code, ErrorCode::collinear);
  line.push_back({0, 0, 1});
  const auto result = reconstruct(line);
  if (result) expect_manifold(*result, "line and a point");
}

TEST(LocalDelaunay, the_corners_of_small_bodies_give_their_closed_surface) {
  const double phi = (1 + std::sqrt(5.0)) / 2;
  std::vector<Point3> icosahedron;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-phi, phi}) icosahedron.insert(icosahedron.end(), {{0, a, b}, {a, b, 0}, {b, 0, a}});
  }
  std::vector<Point3> prism;
  for (const double z : {0.0, 1.0}) prism.insert(prism.end(), {{0, 0, z}, {1, 0, z}, {0.5, 0.8, z}});
  const std::vector<std::vector<Point3>> bodies{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                                {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
                                                {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                                                {{1, 0, 0}, {-0.5, 0.9, 0}, {-0.5, -0.9, 0}, {0, 0, 1}, {0, 0, -1}},
                                                prism,
                                                icosahedron};
  for (const std::vector<Point3>& body : bodies) {
    const auto result = reconstruct(body);
    ASSERT_TRUE(result);
    expect_manifold(*result, std::to_string(body.size()) + " corners");
    const Topology topology = topology_of(result->mesh);
    EXPECT_TRUE(topology.closed) << body.size();
    EXPECT_EQ(topology.vertices, body.size());
    EXPECT_EQ(topology.genus, 0) << body.size();
    EXPECT_GT(signed_volume(result->mesh), 0) << body.size();
  }
}

TEST(LocalDelaunay, is_manifold_on_every_nasty_cloud_with_every_variant) {
  const auto all = variants();
  for (std::uint64_t number = 0; number < 3000; ++number) {
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

TEST(LocalDelaunay, noise_neither_hangs_nor_explodes) {
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
  EXPECT_LE(result->mesh.triangles.size(), 2 * cloud.size());
}

TEST(LocalDelaunay, is_the_same_for_any_order_of_the_points_and_any_number_of_threads) {
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

TEST(LocalDelaunay, is_the_same_with_and_without_wide_registers) {
  const std::vector<Point3> points = testing::random_torus(5000, 8);
  for (const Parameters& parameters : variants()) {
    const auto expected = reconstruct(points, parameters);
    lanes::wide_allowed = false;
    const auto result = reconstruct(points, parameters);
    lanes::wide_allowed = true;
    EXPECT_EQ(result->mesh.triangles, expected->mesh.triangles);
  }
}

TEST(LocalDelaunay, is_the_same_at_any_power_of_two_scale) {
  const std::vector<Point3> points = testing::random_torus(3000, 4);
  const auto expected = reconstruct(points);
  for (const double scale : {0x1p-70, 0x1p60}) {
    std::vector<Point3> scaled = points;
    for (Point3& p : scaled) {
      for (double& x : p) x *= scale;
    }
    EXPECT_EQ(reconstruct(scaled)->mesh.triangles, expected->mesh.triangles);
  }
}

TEST(LocalDelaunay, max_edge_keeps_an_opening_open_that_the_front_would_cross) {
  auto points = testing::sphere_points(4000);
  std::erase_if(points, [](const Point3& p) { return p[2] > 0.96; });
  const auto result = reconstruct(points, {.max_edge = 2.5});
  ASSERT_TRUE(result);
  const Topology topology = topology_of(result->mesh);
  EXPECT_EQ(topology.boundary_loops, 1U);
  EXPECT_EQ(topology.vertices, points.size());
  for (const Triangle& t : result->mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      constexpr double kAcross = 0.56;
      EXPECT_LT(norm(result->mesh.positions[t[i]] - result->mesh.positions[t[(i + 1) % 3]]), kAcross / 2);
    }
  }
}

TEST(LocalDelaunay, can_be_cancelled_in_every_stage_and_its_progress_never_falls) {
  const PointCloud cloud = *make_cloud(testing::raw_cloud(testing::random_torus(5000, 7)));
  std::vector<std::string> stages;
  double last = 0;
  bool falls = false;
  {
    Context context(1, [&](double fraction, std::string_view stage) {
      falls |= fraction < last;
      last = fraction;
      if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
    });
    ASSERT_TRUE(local_delaunay(cloud, {}, context));
  }
  EXPECT_FALSE(falls);
  EXPECT_THAT(stages, ::testing::ElementsAre("neighbourhoods", "consensus", "front", "holes", "surface"));
  stages.pop_back();  // after it there is nothing left to stop
  for (const std::string& at : stages) {
    std::atomic<bool> cancel{false};
    Context context(
        1, [&](double, std::string_view stage) { cancel = cancel || stage == at; }, &cancel);
    const auto result = local_delaunay(cloud, {}, context);
    ASSERT_FALSE(result) << at;
    EXPECT_EQ(result.error().code, ErrorCode::cancelled);
  }
}

}  // namespace
}  // namespace surfaced
