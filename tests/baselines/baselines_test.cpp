// SPDX-License-Identifier: GPL-3.0-or-later
#include "baselines/baselines.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>

#include "support/shapes.hpp"

namespace surfaced {
namespace {

PointCloud cloud_of(const std::vector<Point3>& points) { return *make_cloud(testing::raw_cloud(points)); }

Result<TriangleMesh> front_of(const std::vector<Point3>& points) {
  Context context;
  return advancing_front(cloud_of(points), {}, context);
}

TEST(AdvancingFront, closes_an_even_sphere_through_every_point_and_faces_outwards) {
  const auto mesh = front_of(testing::sphere_points(800));
  ASSERT_TRUE(mesh) << mesh.error().detail;
  const Topology topology = topology_of(*mesh);
  EXPECT_TRUE(topology.closed && topology.vertex_manifold && topology.oriented);
  EXPECT_EQ(topology.genus, 0);
  EXPECT_EQ(topology.vertices, 800U);
  EXPECT_GT(signed_volume(*mesh), 4.1);
}

TEST(AdvancingFront, finds_the_hole_of_a_torus) {
  const auto mesh = front_of(testing::torus_points(60, 20));
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(topology_of(*mesh).genus, 1);
}

TEST(AdvancingFront, two_spheres_stay_two) {
  std::vector<Point3> points = testing::sphere_points(300);
  for (const Point3& p : testing::sphere_points(300, {5, 0, 0})) points.push_back(p);
  const auto mesh = front_of(points);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(topology_of(*mesh).components, 2U);
}

TEST(AdvancingFront, gives_a_flat_sheet_for_coplanar_points) {
  std::vector<Point3> points;
  for (const Point3& p : testing::random_points(200, 4)) points.push_back({p[0], p[1], 0});
  const auto mesh = front_of(points);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  const Topology topology = topology_of(*mesh);
  EXPECT_GT(topology.triangles, 200U);
  EXPECT_FALSE(topology.closed);
  EXPECT_TRUE(topology.edge_manifold);
}

TEST(AdvancingFront, is_the_same_at_any_power_of_two_scale) {
  const std::vector<Point3> points = testing::sphere_points(500);
  const auto reference = front_of(points);
  ASSERT_TRUE(reference);
  for (const int exponent : {-90, -20, 20, 90}) {
    std::vector<Point3> scaled = points;
    for (Point3& p : scaled) {
      for (double& x : p) x = std::ldexp(x, exponent);
    }
    const auto mesh = front_of(scaled);
    ASSERT_TRUE(mesh) << mesh.error().detail;
    EXPECT_EQ(mesh->triangles, reference->triangles) << "scaled by 2^" << exponent;
  }
}

TEST(AdvancingFront, is_the_same_for_any_order_of_the_points) {
  std::vector<Point3> points = testing::torus_points(40, 16);
  const auto reference = front_of(points);
  std::ranges::shuffle(points, std::mt19937(8));
  const auto mesh = front_of(points);
  ASSERT_TRUE(reference && mesh);
  EXPECT_EQ(mesh->triangles, reference->triangles);
}

TEST(AdvancingFront, refuses_fewer_than_3_points_and_says_how_many_remain) {
  const auto mesh = front_of({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {2, 2, 2}});
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::too_few_points);
  EXPECT_NE(mesh.error().detail.find("2 distinct points of 4"), std::string::npos) << mesh.error().detail;
}

TEST(AdvancingFront, refuses_collinear_points) {
  std::vector<Point3> points;
  for (int i = 0; i < 50; ++i) points.push_back({0.5 * i, 0.25 * i, -2.0 * i});
  const auto mesh = front_of(points);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::collinear);
}

TEST(AdvancingFront, stops_when_cancelled) {
  const std::atomic<bool> cancel = true;
  Context context(1, {}, &cancel);
  const auto mesh = advancing_front(cloud_of(testing::sphere_points(100)), {}, context);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::cancelled);
}

TEST(AdvancingFront, survives_random_degenerate_lattices) {
  std::mt19937 random(2);
  for (int run = 0; run < 200; ++run) {
    std::vector<Point3> points;
    const std::size_t n = 3 + random() % 30;
    for (std::size_t i = 0; i < n; ++i) {
      points.push_back(
          {static_cast<double>(random() % 4), static_cast<double>(random() % 4), static_cast<double>(random() % 3)});
    }
    const auto mesh = front_of(points);
    if (mesh) {
      ASSERT_TRUE(topology_of(*mesh).edge_manifold) << "run " << run;
    } else {
      ASSERT_TRUE(mesh.error().code == ErrorCode::collinear || mesh.error().code == ErrorCode::too_few_points)
          << mesh.error().detail;
    }
  }
}

}  // namespace
}  // namespace surfaced
