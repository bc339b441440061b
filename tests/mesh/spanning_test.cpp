// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/spanning.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/shapes.hpp"

namespace surfaced {
namespace {

/// A sheet of rows and columns of points, two triangles a field; `place` says where point (i, j) is.
TriangleMesh sheet(std::size_t rows, std::size_t columns, const std::function<Point3(double, double)>& place) {
  TriangleMesh mesh;
  const auto at = [&](std::size_t i, std::size_t j) { return i * columns + j; };
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < columns; ++j) {
      // Shifted a little, as no scan is a grid.
      const double shift = 0.2 * std::sin(static_cast<double>(7 * i + 13 * j));
      mesh.positions.push_back(place(static_cast<double>(i) + shift, static_cast<double>(j) - shift));
    }
  }
  for (std::size_t i = 0; i + 1 < rows; ++i) {
    for (std::size_t j = 0; j + 1 < columns; ++j) {
      mesh.triangles.push_back(testing::triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1)));
      mesh.triangles.push_back(testing::triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1)));
    }
  }
  return mesh;
}

Point3 flat(double x, double y) { return {x, y, 0}; }

/// The sheet without the fields first..last of both directions, spanned by a fan over the rim of the hole.
TriangleMesh spanned_sheet(std::size_t side, std::size_t first, std::size_t last) {
  TriangleMesh mesh = sheet(side, side, flat);
  const auto inside = [&](VertexIndex v) {
    const std::size_t i = v / side;
    const std::size_t j = v % side;
    return i >= first && i <= last && j >= first && j <= last;
  };
  std::erase_if(mesh.triangles, [&](const Triangle& t) { return inside(t[0]) && inside(t[1]) && inside(t[2]); });
  std::vector<std::size_t> rim;
  for (std::size_t k = first; k < last; ++k) rim.push_back(k * side + first);
  for (std::size_t k = first; k < last; ++k) rim.push_back(last * side + k);
  for (std::size_t k = last; k > first; --k) rim.push_back(k * side + last);
  for (std::size_t k = last; k > first; --k) rim.push_back(first * side + k);
  // From a corner no triangle is flat, but along its own sides.
  for (std::size_t k = 1; k + 1 < rim.size(); ++k)
    mesh.triangles.push_back(testing::triangle(rim[0], rim[k], rim[k + 1]));
  return mesh;
}

/// A grid closed by a fan from a point of its hole's rim.
TEST(SpannedOpenings, are_found_and_opened) {
  TriangleMesh mesh = spanned_sheet(30, 8, 20);
  ASSERT_EQ(topology_of(mesh).boundary_loops, 1U);
  ASSERT_EQ(spanned_openings(mesh).size(), 1U);
  EXPECT_GT(spanned_openings(mesh).front().longest_edge, 12);
  open_up(mesh, spanned_openings(mesh));
  const Topology topology = topology_of(mesh);
  EXPECT_EQ(topology.boundary_loops, 2U);
  EXPECT_TRUE(topology.vertex_manifold);
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LT(norm(mesh.positions[t.at(k)] - mesh.positions[t.at((k + 1) % 3)]), 4.5);
    }
  }
}

TEST(SpannedOpenings, are_none_where_few_points_are_missing) {
  TriangleMesh mesh = spanned_sheet(30, 8, 11);
  EXPECT_TRUE(spanned_openings(mesh).empty());
}

TEST(SpannedOpenings, are_none_between_sparse_and_dense_regions) {
  const auto denser = [](double x, double y) { return Point3{x < 15 ? x / 3 : x - 10, y, 0}; };
  EXPECT_TRUE(spanned_openings(sheet(30, 30, denser)).empty());
}

TEST(SpannedOpenings, are_none_between_scan_lines) {
  const auto lines = [](double x, double y) { return Point3{x, 8 * std::round(y), 0}; };
  EXPECT_TRUE(spanned_openings(sheet(60, 12, lines)).empty());
}

TEST(SpannedOpenings, are_none_on_closed_bodies) {
  EXPECT_TRUE(spanned_openings(testing::torus_mesh(60, 20)).empty());
  EXPECT_TRUE(spanned_openings(testing::tetrahedron()).empty());
  EXPECT_TRUE(spanned_openings({}).empty());
}

/// Along a straight rim Delaunay triangulations have slivers between points that lie a little farther back.
TEST(PeelSlivers, takes_slivers_from_a_rim_and_leaves_no_vertex_alone) {
  TriangleMesh mesh = sheet(20, 20, flat);
  const std::size_t triangles = mesh.triangles.size();
  ASSERT_EQ(peel_slivers(mesh), 0U);
  // Across three points of the first column, almost on a line.
  mesh.triangles.push_back(testing::triangle(40, 20, 0));
  ASSERT_TRUE(topology_of(mesh).oriented);
  EXPECT_EQ(peel_slivers(mesh), 1U);
  EXPECT_EQ(mesh.triangles.size(), triangles);
  EXPECT_TRUE(topology_of(mesh).vertex_manifold);
}

}  // namespace
}  // namespace surfaced
