// SPDX-License-Identifier: GPL-3.0-or-later
#include "quality/quality.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "support/shapes.hpp"

namespace surfaced {
namespace {

TEST(ShapeOf, equilateral_triangle_reaches_both_upper_bounds) {
  const TriangleShape shape = shape_of({0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(3.0) / 2, 0});
  EXPECT_NEAR(shape.shortest_edge_to_circumradius, kMaxShortestEdgeToCircumradius, 1e-12);
  EXPECT_NEAR(shape.inradius_to_longest_edge, kMaxInradiusToLongestEdge, 1e-12);
}

TEST(ShapeOf, right_triangle_3_4_5_has_the_known_radii) {
  const TriangleShape shape = shape_of({0, 0, 0}, {3, 0, 0}, {0, 4, 0});
  EXPECT_DOUBLE_EQ(shape.shortest_edge_to_circumradius, 3 / 2.5);
  EXPECT_DOUBLE_EQ(shape.inradius_to_longest_edge, 1.0 / 5);
  EXPECT_DOUBLE_EQ(shape.area, 6);
}

TEST(ShapeOf, degenerate_triangles_give_0) {
  for (const TriangleShape& shape :
       {shape_of({1, 2, 3}, {1, 2, 3}, {1, 2, 3}), shape_of({0, 0, 0}, {0, 0, 0}, {1, 0, 0}),
        shape_of({0, 0, 0}, {1, 1, 1}, {3, 3, 3})}) {
    EXPECT_EQ(shape.shortest_edge_to_circumradius, 0);
    EXPECT_EQ(shape.inradius_to_longest_edge, 0);
    EXPECT_EQ(shape.area, 0);
  }
}

/// The textbook formulas in long double.
TEST(ShapeOf, agrees_with_the_textbook_formulas_and_the_bounds_on_random_triangles) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (int run = 0; run < 20000; ++run) {
    std::array<Point3, 3> p;
    for (Point3& q : p) q = {coordinate(random), coordinate(random), coordinate(random)};
    const auto length = [&](int i, int j) {
      long double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const long double d = static_cast<long double>(p[static_cast<std::size_t>(i)][k]) -
                              static_cast<long double>(p[static_cast<std::size_t>(j)][k]);
        sum += d * d;
      }
      return std::sqrt(sum);
    };
    std::array<long double, 3> e{length(0, 1), length(1, 2), length(2, 0)};
    std::ranges::sort(e);
    const long double s = (e[0] + e[1] + e[2]) / 2;
    const long double area = std::sqrt(s * (s - e[0]) * (s - e[1]) * (s - e[2]));
    const long double circumradius = e[0] * e[1] * e[2] / (4 * area);
    const TriangleShape shape = shape_of(p[0], p[1], p[2]);
    ASSERT_NEAR(shape.shortest_edge_to_circumradius, static_cast<double>(e[0] / circumradius), 1e-9);
    ASSERT_NEAR(shape.inradius_to_longest_edge, static_cast<double>(area / s / e[2]), 1e-9);
    ASSERT_LE(shape.shortest_edge_to_circumradius, kMaxShortestEdgeToCircumradius);
    ASSERT_LE(shape.inradius_to_longest_edge, kMaxInradiusToLongestEdge);
  }
}

TEST(ShapeOf, is_the_same_at_the_extremes_of_float32) {
  for (const double scale : {1e-38, 1.0, 1e38}) {
    const TriangleShape shape = shape_of({0, 0, 0}, {3 * scale, 0, 0}, {0, 4 * scale, 0});
    EXPECT_NEAR(shape.shortest_edge_to_circumradius, 1.2, 1e-12);
  }
}

TEST(MeasureQuality, of_a_tetrahedron_is_known) {
  const TriangleMesh mesh = testing::tetrahedron();
  const MeshQuality quality = measure_quality(mesh, topology_of(mesh));
  ASSERT_TRUE(quality.volume);
  EXPECT_NEAR(*quality.volume, 8.0 / 3, 1e-12);
  EXPECT_NEAR(quality.area, 4 * 2 * std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(quality.longest_edge_sum, 4 * std::sqrt(8.0), 1e-12);
  EXPECT_EQ(quality.shortest_edge_to_circumradius->histogram.back(), 4U);
}

TEST(MeasureQuality, histogram_counts_every_triangle_and_percentiles_are_ordered) {
  const TriangleMesh mesh = testing::torus_mesh(48, 16);
  const auto q = *measure_quality(mesh, topology_of(mesh)).inradius_to_longest_edge;
  EXPECT_EQ(std::accumulate(q.histogram.begin(), q.histogram.end(), std::uint64_t{0}), mesh.triangles.size());
  EXPECT_LE(q.min, q.p05);
  EXPECT_LE(q.p05, q.p50);
  EXPECT_LE(q.p50, q.p95);
  EXPECT_LE(q.p95, q.max);
  EXPECT_NEAR(q.min, 0.1943, 5e-5);  // paper 3, Table 2, torus: 48 x 16 grid
  EXPECT_NEAR(q.max, 0.2154, 5e-5);
}

TEST(MeasureQuality, an_open_mesh_has_no_volume_and_an_empty_one_no_distribution) {
  TriangleMesh open = testing::tetrahedron();
  open.triangles.pop_back();
  EXPECT_FALSE(measure_quality(open, topology_of(open)).volume);
  EXPECT_FALSE(measure_quality({}, topology_of({})).shortest_edge_to_circumradius);
}

TEST(CountPointsInside, tells_inside_from_outside_and_from_on_the_surface) {
  const TriangleMesh mesh = testing::tetrahedron();
  const std::vector<Point3> inside{{0, 0, 0}, {0.1, 0.1, 0.1}};
  const std::vector<Point3> not_inside{{2, 2, 2}, {1, 1, 1}, {1, 0, 0}, {-0.9, -0.9, -0.9}, {1, 1, -1}};
  EXPECT_EQ(count_points_inside(mesh, inside), 2U);
  EXPECT_EQ(count_points_inside(mesh, not_inside), 0U);
}

TEST(CountPointsInside, agrees_with_the_implicit_torus) {
  const TriangleMesh mesh = testing::torus_mesh(200, 100);
  std::size_t expected = 0;
  std::vector<Point3> points;
  for (const Point3& p : testing::random_points(3000, 9)) {
    const Point3 q{1.4 * p[0], 1.4 * p[1], 0.4 * p[2]};
    const double distance = std::hypot(std::hypot(q[0], q[1]) - 1, q[2]);
    if (std::abs(distance - 0.3) < 0.003) continue;  // between the torus and its mesh
    points.push_back(q);
    expected += distance < 0.3 ? 1 : 0;
  }
  EXPECT_EQ(count_points_inside(mesh, points), expected);
}

TEST(CountSelfIntersections, a_sphere_has_none_and_two_crossing_tetrahedra_have_some) {
  const TriangleMesh mesh = testing::tetrahedron();
  EXPECT_EQ(count_self_intersections(mesh), 0U);
  EXPECT_EQ(count_self_intersections(testing::torus_mesh(20, 10)), 0U);
  EXPECT_GT(count_self_intersections(testing::together(mesh, mesh, {0.5, 0.25, 0.125})), 0U);
  EXPECT_EQ(count_self_intersections(testing::together(mesh, mesh, {0.5, 0.25, 0.125}), 1), 1U);
}

TEST(CountSelfIntersections, a_triangle_folded_onto_its_neighbour_counts) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.5, 0}};
  mesh.triangles = {testing::triangle(0, 1, 2), testing::triangle(1, 0, 3)};
  EXPECT_EQ(count_self_intersections(mesh), 1U);
  mesh.positions[3] = {0.5, -0.5, 0};
  EXPECT_EQ(count_self_intersections(mesh), 0U);
}

/// Two triangles that make a square of the given side at height z.
TriangleMesh square(double side, double z) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, z}, {side, 0, z}, {side, side, z}, {0, side, z}};
  mesh.triangles = {testing::triangle(0, 1, 2), testing::triangle(0, 2, 3)};
  return mesh;
}

TEST(SurfaceDistance, is_known_between_squares) {
  const SurfaceDistance parallel = surface_distance(square(2, 0.25), SurfaceSearch(square(2, 0)));
  EXPECT_DOUBLE_EQ(parallel.lower, 0.25);
  EXPECT_NEAR(parallel.upper, 0.25, 0.025);
  const SurfaceDistance beyond = surface_distance(square(3, 0), SurfaceSearch(square(1, 0)));
  EXPECT_DOUBLE_EQ(beyond.lower, 2 * std::sqrt(2.0));
  EXPECT_LE(beyond.upper, 1.1 * beyond.lower);
  EXPECT_LT(surface_distance(square(1, 0), SurfaceSearch(square(3, 0))).upper, 1e-12) << "one-sided";
}

TEST(SurfaceDistance, finds_the_middle_of_a_triangle_that_spans_a_valley) {
  // All corners lie on the surface; the middle of the long edge hangs one above it.
  TriangleMesh valley;
  valley.positions = {{-2, -5, 1}, {-2, 5, 1}, {0, -5, 0}, {0, 5, 0}, {2, -5, 1}, {2, 5, 1}};
  valley.triangles = {testing::triangle(0, 2, 3), testing::triangle(0, 3, 1), testing::triangle(2, 4, 5),
                      testing::triangle(2, 5, 3)};
  TriangleMesh lid;
  lid.positions = {{-2, 0, 1}, {2, 0, 1}, {2, 1, 1}};
  lid.triangles = {testing::triangle(0, 1, 2)};
  const SurfaceDistance distance = surface_distance(lid, SurfaceSearch(valley));
  const double exact = 2 / std::sqrt(5.0);  // of (0, 0, 1) from both slopes
  EXPECT_LE(distance.lower, exact + 1e-12);
  EXPECT_GE(distance.upper, exact - 1e-12);
  EXPECT_LE(distance.upper, 1.101 * exact);
}

TEST(SurfaceDistance, is_the_same_for_any_number_of_threads_and_bounds_what_is_known) {
  const TriangleMesh coarse = testing::torus_mesh(60, 40);
  const TriangleMesh fine = testing::torus_mesh(120, 80);
  for (const auto& [from, to] : {std::pair{&coarse, &fine}, std::pair{&fine, &coarse}}) {
    const SurfaceSearch search(*to);
    const SurfaceDistance one = surface_distance(*from, search);
    const SurfaceDistance four = surface_distance(*from, search, 4);
    EXPECT_EQ(one.lower, four.lower);
    EXPECT_EQ(one.upper, four.upper);
    EXPECT_LE(one.upper, 1.1 * one.lower);
    EXPECT_GT(one.lower, 1e-3) << "the chord of 1/60 of a circle of radius 1.3 sags by 0.0018";
  }
}

TEST(SurfaceDistance, of_a_mesh_to_itself_is_nothing) {
  const TriangleMesh torus = testing::torus_mesh(30, 20);
  EXPECT_LT(surface_distance(torus, SurfaceSearch(torus)).upper, 1e-11);
}

TEST(SurfaceSearch, finds_what_trying_all_triangles_finds_from_any_hint) {
  const TriangleMesh torus = testing::torus_mesh(12, 9);
  const SurfaceSearch search(torus);
  for (const Point3& query : testing::random_points(50, 7)) {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t place = 0; place < torus.triangles.size(); ++place) {
      best = std::min(best, search.distance_to(place, query));
    }
    for (const std::size_t hint : {std::size_t{0}, torus.triangles.size() - 1}) {
      const SurfaceSearch::Closest closest = search.closest(query, hint);
      EXPECT_NEAR(closest.distance, best, 1e-12);
      EXPECT_NEAR(norm(closest.point - query), best, 1e-12);
      EXPECT_NEAR(search.distance_to(closest.place, query), best, 1e-12);
    }
  }
}

TEST(VertexQuality, is_the_least_of_the_triangles_at_a_vertex) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(3.0) / 2, 0}, {0.5, -0.01, 0}, {9, 9, 9}};
  mesh.triangles = {testing::triangle(0, 1, 2), testing::triangle(0, 3, 1)};
  const VertexQuality quality = vertex_quality(mesh);
  EXPECT_NEAR(quality.inradius_to_longest_edge[2], kMaxInradiusToLongestEdge, 1e-6);
  EXPECT_LT(quality.inradius_to_longest_edge[0], 0.02);
  EXPECT_EQ(quality.inradius_to_longest_edge[0], quality.inradius_to_longest_edge[3]);
  EXPECT_NEAR(quality.shortest_edge_to_circumradius[2], kMaxShortestEdgeToCircumradius, 1e-6);
  EXPECT_EQ(quality.shortest_edge_to_circumradius[4], 0) << "no triangle there";
}

TEST(WallThickness, of_a_torus_is_the_tube_s_diameter) {
  const std::vector<double> walls = wall_thicknesses(testing::torus_mesh(120, 60), 500);
  ASSERT_EQ(walls.size(), 500U);
  EXPECT_TRUE(std::ranges::is_sorted(walls));
  EXPECT_NEAR(walls.front(), 0.6, 0.02);
  EXPECT_NEAR(walls.back(), 0.6, 0.02);
}

TEST(WallThickness, of_an_open_sheet_is_not_known) { EXPECT_TRUE(wall_thicknesses(square(1, 0), 100).empty()); }

}  // namespace
}  // namespace surfaced
