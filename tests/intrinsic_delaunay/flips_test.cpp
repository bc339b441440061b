// SPDX-License-Identifier: GPL-3.0-or-later
#include "intrinsic_delaunay/flips.hpp"

#include <CGAL/Triangulation_2.h>
#include <gtest/gtest.h>

#include <map>

#include "hole_filling/hole_filling.hpp"
#include "intrinsic_delaunay/intrinsic_delaunay.hpp"
#include "support/holes.hpp"
#include "support/nasty_clouds.hpp"
#include "support/planar_delaunay.hpp"

namespace surfaced {
namespace {

/// Edges inside whose opposite angles add up to more than π, by arc cosines.
std::size_t obtuse_edges(const TriangleMesh& mesh, double tolerance) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<double>> angles;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Point3& c = mesh.positions[t[i]];
      const Point3 a = mesh.positions[t[(i + 1) % 3]] - c;
      const Point3 b = mesh.positions[t[(i + 2) % 3]] - c;
      angles[std::minmax<std::size_t>(t[(i + 1) % 3], t[(i + 2) % 3])].push_back(
          std::acos(std::clamp(dot(a, b) / (norm(a) * norm(b)), -1.0, 1.0)));
    }
  }
  std::size_t count = 0;
  for (const auto& [edge, at] : angles) {
    if (at.size() == 2 && at[0] + at[1] > std::numbers::pi + tolerance) ++count;
  }
  return count;
}

TEST(FlipEdges, turns_any_triangulation_of_a_plane_into_the_delaunay_triangulation) {
  // A triangulation by mere insertion, full of slivers.
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::size_t, Kernel>;
  using Structure = CGAL::Triangulation_data_structure_2<VertexBase, CGAL::Triangulation_face_base_2<Kernel>>;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(0, 1);
  std::vector<Point3> points;
  for (int i = 0; i < 400; ++i) points.push_back({coordinate(random), coordinate(random), 0});
  const PointCloud cloud = *make_cloud(testing::raw_cloud(points));
  CGAL::Triangulation_2<Kernel, Structure> bad;
  for (std::size_t v = 0; v < cloud.size(); ++v)
    bad.insert(Kernel::Point_2(cloud.positions[v][0], cloud.positions[v][1]))->info() = v;

  Context context;
  const BoxTree tree(cloud.positions, 1);
  auto stars = front::local_stars(tree, {}, context);
  ASSERT_TRUE(stars);
  front::FaceMasks faces = front::agreed_faces(*stars, 1);
  front::orient(*stars, faces);
  const bool up = stars->normals[0][2] > 0;
  front::Places places(tree, *stars, {});
  front::Fans fans(*stars, front::FaceMasks(cloud.size(), 0));
  for (auto f = bad.finite_faces_begin(); f != bad.finite_faces_end(); ++f) {
    const auto corner = [&](int i) { return static_cast<std::uint32_t>(f->vertex(i)->info()); };
    fans.add(up ? front::Face{corner(0), corner(1), corner(2)} : front::Face{corner(0), corner(2), corner(1)});
  }
  const TriangleMesh before{cloud.positions, fans.triangles(), {}, {}};
  ASSERT_GT(obtuse_edges(before, 0), 100U);

  const auto counts = idt::flip_edges(fans, places, context);
  ASSERT_TRUE(counts);
  const TriangleMesh after{cloud.positions, fans.triangles(), {}, {}};
  EXPECT_GT(counts->flips, 100U);
  EXPECT_EQ(after.triangles.size(), before.triangles.size());
  EXPECT_TRUE(topology_of(after).vertex_manifold);
  EXPECT_EQ(topology_of(after).boundary_edges, topology_of(before).boundary_edges);
  EXPECT_EQ(obtuse_edges(after, 1e-9), counts->not_flippable);
  EXPECT_LE(counts->not_flippable, 3U);
}

TEST(FlipEdges, leaves_no_obtuse_edge_but_those_it_counts) {
  for (const double noise : {0.0, 0.003}) {
    const PointCloud cloud = *make_cloud(testing::raw_cloud(testing::random_torus(6000, 3, noise)));
    Context context;
    const auto result = intrinsic_delaunay(cloud, {}, context);
    ASSERT_TRUE(result);
    constexpr double kRounding = 1e-9;
    EXPECT_EQ(obtuse_edges(result->mesh, kRounding), result->statistics.not_flippable);
    EXPECT_LT(result->statistics.not_flippable, 60U);
    if (noise > 0) {
      EXPECT_GT(result->statistics.flips, 0U);
    }
  }
}

TEST(FlipEdges, makes_a_filled_mesh_intrinsic_delaunay_again_and_keeps_what_it_is) {
  for (const double radius : {0.2, 0.5}) {
    const TriangleMesh whole = testing::bumpy_sphere(5);
    TriangleMesh mesh = testing::cut_disc(whole, whole.positions[7], radius).rest;
    Context context(2);
    ASSERT_TRUE(fill_holes(mesh, {}, context));
    const std::size_t triangles = mesh.triangles.size();
    const std::vector<Point3> positions = mesh.positions;
    EXPECT_GT(certify(mesh, context)->edges_beyond_pi, 0U) << radius;
    const auto counts = idt::flip_edges(mesh, context);
    ASSERT_TRUE(counts);
    EXPECT_GT(counts->flips, 0U);
    EXPECT_EQ(obtuse_edges(mesh, 1e-9), counts->not_flippable);
    EXPECT_EQ(certify(mesh, context)->edges_beyond_pi, counts->not_flippable);
    EXPECT_EQ(testing::manifold_problem(mesh), "");
    EXPECT_TRUE(topology_of(mesh).closed);
    EXPECT_EQ(topology_of(mesh).genus, 0);
    EXPECT_EQ(mesh.triangles.size(), triangles);
    EXPECT_EQ(mesh.positions, positions);
    TriangleMesh again = mesh;
    ASSERT_TRUE(idt::flip_edges(again, context));
    EXPECT_EQ(again.triangles, mesh.triangles);
  }
}

TEST(FlipEdges, keeps_what_was_filled_on_nasty_clouds_manifold) {
  for (std::uint64_t number = 0; number < 1100; ++number) {
    const testing::NastyCloud nasty = testing::NastyClouds::make(number);
    const std::string name = nasty.kind + " " + std::to_string(number);
    Context context(1 + number % 2);
    auto result = intrinsic_delaunay(*make_cloud(testing::raw_cloud(nasty.points)), {}, context);
    if (!result) continue;
    ASSERT_TRUE(fill_holes(result->mesh, {}, context)) << name;
    const Topology before = topology_of(result->mesh);
    const auto counts = idt::flip_edges(result->mesh, context);
    ASSERT_TRUE(counts) << name;
    const Topology after = topology_of(result->mesh);
    EXPECT_EQ(testing::manifold_problem(result->mesh), "") << name;
    EXPECT_EQ(after.triangles, before.triangles) << name;
    EXPECT_EQ(after.boundary_edges, before.boundary_edges) << name;
    EXPECT_EQ(after.euler_characteristic, before.euler_characteristic) << name;
  }
}

TEST(FlipEdges, takes_the_better_of_two_diagonals_that_are_both_delaunay) {
  // Four points out of a plane: over either diagonal the opposite angles add up to less than π.
  const std::vector<Point3> points{{-1, 0, 0.55}, {1, 0, 0.55}, {0, -0.85, 0}, {0, 0.85, 0}};
  TriangleMesh mesh{points, {testing::triangle(0, 2, 1), testing::triangle(0, 1, 3)}, {}, {}};
  Context context;
  const auto counts = idt::flip_edges(mesh, context);
  ASSERT_TRUE(counts);
  EXPECT_EQ(counts->flips, 0U);
  EXPECT_EQ(counts->exchanges, 1U);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{testing::triangle(0, 2, 3), testing::triangle(1, 3, 2)}));
  EXPECT_EQ(certify(mesh, context)->edges_beyond_pi, 0U);
}

TEST(AnglesExceedPi, is_false_for_four_points_on_a_circle) {
  const PointCloud cloud =
      *make_cloud(testing::raw_cloud({{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {3, 0, 0}, {0, 3, 0}}));
  Context context;
  const BoxTree tree(cloud.positions, 1);
  const auto stars = front::local_stars(tree, {}, context);
  ASSERT_TRUE(stars);
  const front::Places places(tree, *stars, {});
  const auto at = [&](double x, double y) {
    for (std::uint32_t v = 0; v < cloud.size(); ++v) {
      if (cloud.positions[v] == Point3{x, y, 0}) return v;
    }
    return front::kNoVertex;
  };
  EXPECT_FALSE(idt::angles_exceed_pi(places, {at(1, 0), at(-1, 0), at(0, 1), at(0, -1)}));
  EXPECT_TRUE(idt::angles_exceed_pi(places, {at(3, 0), at(-1, 0), at(0, 1), at(0, -1)}));
  EXPECT_FALSE(idt::angles_exceed_pi(places, {at(1, 0), at(-1, 0), at(0, 3), at(0, -1)}));
}

}  // namespace
}  // namespace surfaced
