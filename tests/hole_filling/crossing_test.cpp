// SPDX-License-Identifier: GPL-3.0-or-later
// What is put into a hole crosses nothing, and stays bounded.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hole_filling/hole_filling.hpp"
#include "quality/quality.hpp"
#include "support/holes.hpp"

namespace surfaced {
namespace {

using ::testing::HasSubstr;

/// A sphere with a hole about the z axis, and a triangle that stands in it between the given heights.
TriangleMesh pierced(double low, double high) {
  TriangleMesh mesh = testing::cut_disc(testing::bumpy_sphere(4, 0), {0, 0, 1}, 0.5).rest;
  const std::size_t first = mesh.positions.size();
  for (const Point3& p : {Point3{-0.05, 0.01, high}, Point3{0.05, 0.01, high}, Point3{0, 0.01, low}}) {
    mesh.positions.push_back(p);
  }
  mesh.triangles.push_back(testing::triangle(first, first + 1, first + 2));
  return mesh;
}

/// Of the hole; the triangle's rim is a loop as well.
struct Filled {
  FillReport report;
  std::size_t crossings = 0;
  double height = 0;
};

Filled filled(TriangleMesh mesh) {
  const std::size_t before = mesh.positions.size();
  Context context;
  Filled result{.report = fill_holes(mesh, {}, context).value()};
  result.crossings = count_self_intersections(mesh);
  for (std::size_t v = before; v < mesh.positions.size(); ++v)
    result.height = std::max(result.height, mesh.positions[v][2]);
  return result;
}

TEST(FillHoles, follows_the_surface_around_where_nothing_stands_there) {
  const Filled free = filled(pierced(2, 3));
  EXPECT_EQ(free.crossings, 0U);
  EXPECT_GT(free.height, 0.97);
}

TEST(FillHoles, stays_nearer_to_the_membrane_where_the_surface_would_be_crossed) {
  const Filled under = filled(pierced(0.94, 3));
  EXPECT_EQ(under.crossings, 0U);
  EXPECT_GT(under.report.vertices_added, 10U);
  EXPECT_LT(under.height, 0.96);
}

TEST(FillHoles, leaves_a_hole_that_nothing_covers_without_crossing) {
  const Filled none = filled(pierced(0.2, 3));
  EXPECT_EQ(none.crossings, 0U);
  EXPECT_EQ(none.report.vertices_added, 0U);
  ASSERT_FALSE(none.report.left.empty());
  EXPECT_THAT(none.report.left.front().reason, HasSubstr("without crossing another"));
}

TEST(IntersectionsFrom, are_those_of_all_that_touch_what_is_new) {
  TriangleMesh mesh = testing::bumpy_sphere(2, 0);
  const std::size_t first = mesh.triangles.size();
  EXPECT_TRUE(intersections_from(mesh, 0).empty());
  const std::size_t v = mesh.positions.size();
  for (const Point3& p : {Point3{0, 0, 0}, Point3{2, 0.1, 0.3}, Point3{2, 0.3, 0.1}}) mesh.positions.push_back(p);
  mesh.triangles.push_back(testing::triangle(v, v + 1, v + 2));
  EXPECT_EQ(intersections_from(mesh, first).size(), count_self_intersections(mesh));
  EXPECT_GT(count_self_intersections(mesh), 0U);
  EXPECT_TRUE(intersections_from(mesh, first + 1).empty());
}

}  // namespace
}  // namespace surfaced
