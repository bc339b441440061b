// SPDX-License-Identifier: GPL-3.0-or-later
// What every method that grows a front promises, as one set of tests. A method gives them
//   using Parameters
//   static std::vector<Parameters> variants()                          the default first
//   static Parameters scaled(Parameters, double factor)                for points multiplied by the factor
//   static std::vector<std::string> stages()
//   static Result<testing::Grown> run(const PointCloud&, const Parameters&, Context&)
// and a test file instantiates them.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "base/lanes.hpp"
#include "support/holes.hpp"
#include "support/manifolds.hpp"
#include "support/nasty_clouds.hpp"
#include "support/planar_delaunay.hpp"
#include "support/shapes.hpp"

namespace surfaced::testing {

struct Grown {
  TriangleMesh mesh;
  /// As the method counts them.
  std::size_t open_edges = 0;
};

/// Corners of bodies so small that their normals mean little.
inline std::vector<std::vector<Point3>> small_bodies() {
  const double phi = (1 + std::sqrt(5.0)) / 2;
  std::vector<Point3> icosahedron;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-phi, phi}) icosahedron.insert(icosahedron.end(), {{0, a, b}, {a, b, 0}, {b, 0, a}});
  }
  std::vector<Point3> prism;
  for (const double z : {0.0, 1.0}) prism.insert(prism.end(), {{0, 0, z}, {1, 0, z}, {0.5, 0.8, z}});
  std::vector<Point3> cube;
  for (int i = 0; i < 8; ++i) cube.push_back({1.0 * (i & 1), 1.0 * (i >> 1 & 1), 1.0 * (i >> 2)});
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
          {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
          {{1, 0, 0}, {-0.5, 0.9, 0}, {-0.5, -0.9, 0}, {0, 0, 1}, {0, 0, -1}},
          cube,
          prism,
          icosahedron};
}

/// Clouds of several thousand points, so that threads share the work.
inline std::vector<NastyCloud> large_nasty_clouds() {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> noise(0, 0.01);
  NastyCloud sheets{"noisy sheets", {}};
  for (int i = 0; i < 5000; ++i) sheets.points.push_back({unit(random), unit(random), (i % 3) * 0.02 + noise(random)});
  NastyCloud lattice{"lattice", {}};
  for (int i = 0; i < 15 * 15 * 15; ++i)
    lattice.points.push_back({1.0 * (i % 15), 1.0 * (i / 15 % 15), 1.0 * (i / 225)});
  NastyCloud repeats{"repeats", torus_points(90, 30)};
  repeats.points.insert(repeats.points.end(), repeats.points.begin(), repeats.points.begin() + 1000);
  NastyCloud scales{"dense in sparse", random_points(1500, 4)};
  for (Point3 p : sphere_points(3000)) {
    for (double& x : p) x = 0.5 + 1e-6 * x;
    scales.points.push_back(p);
  }
  return {
      std::move(sheets), std::move(lattice), std::move(repeats), std::move(scales), {"cube", random_points(5000, 3)}};
}

/// Of the unit sphere: closed, outwards, with every point.
inline void expect_whole_sphere(const TriangleMesh& mesh, std::size_t points) {
  const Topology topology = topology_of(mesh);
  EXPECT_EQ(topology.vertices, points);
  EXPECT_EQ(topology.genus, 0);
  EXPECT_TRUE(topology.closed);
  EXPECT_GT(signed_volume(mesh), 4.1);
}

template <class Method>
class FrontClaims : public ::testing::Test {
 protected:
  using Parameters = typename Method::Parameters;

  static Result<Grown> reconstruct(const std::vector<Point3>& points, const Parameters& parameters = {},
                                   unsigned threads = 1) {
    Context context(threads);
    return Method::run(*make_cloud(raw_cloud(points), threads), parameters, context);
  }

  static void expect_manifold(const Grown& grown, const std::string& name) {
    expect_oriented_manifold(grown.mesh, name);
    EXPECT_EQ(topology_of(grown.mesh).boundary_edges, grown.open_edges) << name;
  }

  static void expect_refusal(const Error& error, const std::string& name) {
    EXPECT_TRUE(error.code == ErrorCode::too_few_points || error.code == ErrorCode::collinear) << name;
  }

  /// The mesh by brute force, and that any order of the points and 1, 2 or 3 threads give the same one.
  static void check(const NastyCloud& nasty, const Parameters& parameters, const std::string& name) {
    std::vector<Point3> points = nasty.points;
    std::optional<TriangleMesh> expected;
    std::mt19937 random(5);
    for (const unsigned threads : {1U, 2U, 3U}) {
      const PointCloud cloud = *make_cloud(raw_cloud(points), threads);
      Context context(threads);
      const Result<Grown> result = Method::run(cloud, parameters, context);
      std::ranges::shuffle(points, random);
      if (!result) {
        expect_refusal(result.error(), name);
        EXPECT_FALSE(expected) << name;
        continue;
      }
      if (!expected) {
        EXPECT_EQ(manifold_problem(result->mesh), "") << name;
        EXPECT_EQ(result->mesh.positions, cloud.positions) << name;
        EXPECT_LE(result->mesh.triangles.size(), 2 * points.size()) << name;
        expected = result->mesh;
      }
      EXPECT_EQ(result->mesh.positions, expected->positions) << name;
      EXPECT_EQ(result->mesh.triangles, expected->triangles) << name;
    }
  }
};

TYPED_TEST_SUITE_P(FrontClaims);

TYPED_TEST_P(FrontClaims, interpolates_every_point_of_a_sphere_and_faces_outwards) {
  const auto result = this->reconstruct(sphere_points(3000));
  ASSERT_TRUE(result);
  expect_whole_sphere(result->mesh, 3000);
}

TYPED_TEST_P(FrontClaims, finds_the_handle_of_a_torus_also_where_the_points_are_random) {
  for (const auto& points : {torus_points(60, 24), random_torus(8000, 1)}) {
    const auto result = this->reconstruct(points);
    ASSERT_TRUE(result);
    const Topology topology = topology_of(result->mesh);
    EXPECT_TRUE(topology.closed);
    EXPECT_EQ(topology.genus, 1);
    EXPECT_EQ(topology.vertices, points.size());
  }
}

TYPED_TEST_P(FrontClaims, two_spheres_stay_two) {
  auto points = sphere_points(500);
  const auto other = sphere_points(700, {4, 0, 0});
  points.insert(points.end(), other.begin(), other.end());
  const auto result = this->reconstruct(points);
  ASSERT_TRUE(result);
  const Topology topology = topology_of(result->mesh);
  EXPECT_EQ(topology.components, 2U);
  EXPECT_TRUE(topology.closed);
  EXPECT_EQ(topology.genus, 0);
}

TYPED_TEST_P(FrontClaims, equals_the_two_dimensional_delaunay_triangulation_inside_the_rim_of_a_plane) {
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
    const PointCloud cloud = tilted_square(6000, seed);
    Context context;
    const auto result = TypeParam::run(cloud, {}, context);
    ASSERT_TRUE(result);
    EXPECT_EQ(triples_inside(result->mesh), delaunay_triples_inside(cloud));
    const Topology topology = topology_of(result->mesh);
    EXPECT_FALSE(topology.closed);
    EXPECT_EQ(topology.boundary_loops, 1U);
    EXPECT_EQ(topology.components, 1U);
    EXPECT_EQ(topology.vertices, cloud.size());
  }
}

TYPED_TEST_P(FrontClaims, a_grid_gives_a_sheet_with_one_rim) {
  std::vector<Point3> points;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 30; ++j) points.push_back({1.0 * i, 1.0 * j, 5});
  }
  const auto result = this->reconstruct(points);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->mesh.triangles.size(), 2U * 39 * 29);
  EXPECT_EQ(topology_of(result->mesh).boundary_loops, 1U);
}

TYPED_TEST_P(FrontClaims, the_smallest_inputs_give_what_there_is) {
  const auto triangle = this->reconstruct({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  ASSERT_TRUE(triangle);
  EXPECT_EQ(triangle->mesh.triangles.size(), 1U);
  const auto square = this->reconstruct({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
  ASSERT_TRUE(square);
  EXPECT_EQ(square->mesh.triangles.size(), 2U);
}

TYPED_TEST_P(FrontClaims, the_corners_of_small_bodies_give_their_closed_surface) {
  for (const std::vector<Point3>& body : small_bodies()) {
    const std::string name = std::to_string(body.size()) + " corners";
    const auto result = this->reconstruct(body);
    ASSERT_TRUE(result) << name;
    this->expect_manifold(*result, name);
    const Topology topology = topology_of(result->mesh);
    EXPECT_TRUE(topology.closed) << name;
    EXPECT_EQ(topology.vertices, body.size()) << name;
    EXPECT_EQ(topology.triangles, 2 * body.size() - 4) << name;
    EXPECT_EQ(topology.genus, 0) << name;
    EXPECT_GT(signed_volume(result->mesh), 0) << name;
  }
}

TYPED_TEST_P(FrontClaims, refuses_too_few_points_and_points_on_a_line_with_typed_errors) {
  EXPECT_EQ(this->reconstruct({}).error().code, ErrorCode::too_few_points);
  EXPECT_EQ(this->reconstruct({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}}).error().code, ErrorCode::too_few_points);
  EXPECT_THAT(this->reconstruct({{0, 0, 0}, {1, 0, 0}}).error().detail, ::testing::HasSubstr("-delaunay needs 3"));
  std::vector<Point3> line;
  for (int i = 0; i < 100; ++i) line.push_back({1.0 * i, 2.0 * i, -3.0 * i});
  EXPECT_EQ(this->reconstruct(line).error().code, ErrorCode::collinear);
  line.push_back({0, 0, 1});
  const auto result = this->reconstruct(line);
  if (result) this->expect_manifold(*result, "line and a point");
}

TYPED_TEST_P(FrontClaims, is_manifold_on_every_nasty_cloud_with_every_variant) {
  const auto all = TypeParam::variants();
  for (std::uint64_t number = 0; number < 2500; ++number) {
    const NastyCloud nasty = NastyClouds::make(number);
    const std::string name = nasty.kind + " " + std::to_string(number);
    const auto result = this->reconstruct(nasty.points, all[number / 11 % all.size()]);
    result ? this->expect_manifold(*result, name) : this->expect_refusal(result.error(), name);
  }
}

TYPED_TEST_P(FrontClaims, hold_by_brute_force_in_any_order_and_on_any_threads_on_nasty_clouds) {
  const auto all = TypeParam::variants();
  for (std::uint64_t number = 5000; number < 5880; ++number) {
    const NastyCloud nasty = NastyClouds::make(number);
    this->check(nasty, all[number / 11 % all.size()], nasty.kind + " " + std::to_string(number));
  }
}

TYPED_TEST_P(FrontClaims, hold_by_brute_force_on_clouds_large_enough_for_threads_to_share) {
  for (const NastyCloud& nasty : large_nasty_clouds()) {
    for (const auto& parameters : TypeParam::variants()) this->check(nasty, parameters, nasty.kind);
  }
}

TYPED_TEST_P(FrontClaims, noise_neither_hangs_nor_explodes) {
  for (const double noise : {0.003, 0.01, 0.03, 0.1}) {
    const auto points = random_torus(6000, 5, noise);
    for (const auto& parameters : TypeParam::variants()) {
      const auto result = this->reconstruct(points, parameters);
      ASSERT_TRUE(result);
      this->expect_manifold(*result, "noise " + std::to_string(noise));
      EXPECT_LE(result->mesh.triangles.size(), 2 * points.size());
    }
  }
}

TYPED_TEST_P(FrontClaims, is_the_same_with_and_without_wide_registers) {
  const std::vector<Point3> points = random_torus(5000, 8);
  for (const auto& parameters : TypeParam::variants()) {
    const auto expected = this->reconstruct(points, parameters);
    lanes::wide_allowed = false;
    const auto result = this->reconstruct(points, parameters);
    lanes::wide_allowed = true;
    EXPECT_EQ(result->mesh.triangles, expected->mesh.triangles);
  }
}

TYPED_TEST_P(FrontClaims, is_the_same_at_any_power_of_two_scale) {
  const std::vector<Point3> points = random_torus(3000, 4);
  for (const auto& parameters : TypeParam::variants()) {
    const auto expected = this->reconstruct(points, parameters);
    for (const double scale : {0x1p-70, 0x1p60}) {
      std::vector<Point3> scaled = points;
      for (Point3& p : scaled) {
        for (double& x : p) x *= scale;
      }
      EXPECT_EQ(this->reconstruct(scaled, TypeParam::scaled(parameters, scale))->mesh.triangles,
                expected->mesh.triangles);
    }
  }
}

TYPED_TEST_P(FrontClaims, can_be_cancelled_in_every_stage_and_progress_never_falls) {
  const PointCloud cloud = *make_cloud(raw_cloud(random_torus(5000, 7)));
  std::vector<std::string> stages;
  double last = 0;
  bool falls = false;
  {
    Context context(1, [&](double fraction, std::string_view stage) {
      falls |= fraction < last;
      last = fraction;
      if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
    });
    ASSERT_TRUE(TypeParam::run(cloud, {}, context));
  }
  EXPECT_FALSE(falls);
  EXPECT_EQ(stages, TypeParam::stages());
  stages.pop_back();  // after it there is nothing left to stop
  for (const std::string& at : stages) {
    std::atomic<bool> cancel{false};
    Context context(
        1, [&](double, std::string_view stage) { cancel = cancel || stage == at; }, &cancel);
    const auto result = TypeParam::run(cloud, {}, context);
    ASSERT_FALSE(result) << at;
    EXPECT_EQ(result.error().code, ErrorCode::cancelled);
  }
}

REGISTER_TYPED_TEST_SUITE_P(FrontClaims, interpolates_every_point_of_a_sphere_and_faces_outwards,
                            finds_the_handle_of_a_torus_also_where_the_points_are_random, two_spheres_stay_two,
                            equals_the_two_dimensional_delaunay_triangulation_inside_the_rim_of_a_plane,
                            a_grid_gives_a_sheet_with_one_rim, the_smallest_inputs_give_what_there_is,
                            the_corners_of_small_bodies_give_their_closed_surface,
                            refuses_too_few_points_and_points_on_a_line_with_typed_errors,
                            is_manifold_on_every_nasty_cloud_with_every_variant,
                            hold_by_brute_force_in_any_order_and_on_any_threads_on_nasty_clouds,
                            hold_by_brute_force_on_clouds_large_enough_for_threads_to_share,
                            noise_neither_hangs_nor_explodes, is_the_same_with_and_without_wide_registers,
                            is_the_same_at_any_power_of_two_scale,
                            can_be_cancelled_in_every_stage_and_progress_never_falls);

}  // namespace surfaced::testing
