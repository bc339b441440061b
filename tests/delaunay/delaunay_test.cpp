// SPDX-License-Identifier: GPL-3.0-or-later
#include "delaunay/delaunay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>
#include <set>

#include "support/shapes.hpp"

namespace surfaced {
namespace {

using testing::raw_cloud;

PointCloud cloud_of(std::vector<Point3> points) { return *make_cloud(raw_cloud(std::move(points))); }

DelaunayComplex complex_of(const PointCloud& cloud, unsigned threads = 1) {
  Context context(threads);
  return *delaunay_complex(cloud, context, 1);
}

ErrorCode error_of(std::vector<Point3> points, std::string* detail = nullptr) {
  Context context;
  const auto complex = delaunay_complex(cloud_of(std::move(points)), context, 1);
  if (complex) return ErrorCode::internal_error;
  if (detail != nullptr) *detail = complex.error().detail;
  return complex.error().code;
}

std::vector<Point3> grid(int side) {
  std::vector<Point3> points;
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      for (int z = 0; z < side; ++z) points.push_back({1.0 * x, 1.0 * y, 1.0 * z});
    }
  }
  return points;
}

/// Of volumes computed in double from coordinates of about 1; cells on a sphere may be that flat.
constexpr double kRounding = 1e-15;

double signed_volume_of(const DelaunayComplex& complex, std::size_t c) {
  const auto at = [&](std::size_t i) { return complex.positions[complex.vertex(4 * c + i)]; };
  const double volume = dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))) / 6;
  return complex.mirrored[c] != 0 ? -volume : volume;
}

std::vector<std::vector<Point3>> clouds() {
  return {testing::random_points(4, 1), testing::random_points(5, 2),  testing::random_points(300, 3),
          testing::sphere_points(500),  testing::torus_points(20, 12), grid(4)};
}

TEST(Delaunay, mates_are_the_same_facet_seen_from_two_cells) {
  for (const auto& points : clouds()) {
    const DelaunayComplex complex = complex_of(cloud_of(points));
    for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
      const SideIndex mate = complex.mate(s);
      ASSERT_EQ(complex.mate(mate), SideIndex(s));
      ASSERT_NE(mate / 4, s / 4);
      ASSERT_EQ(complex.facet(mate), complex.facet(SideIndex(s)));
    }
  }
}

TEST(Delaunay, cells_and_their_vertices_ascend) {
  for (const auto& points : clouds()) {
    const DelaunayComplex complex = complex_of(cloud_of(points));
    for (std::size_t c = 0; c < complex.cells(); ++c) {
      for (std::size_t i = 0; i < 3; ++i) ASSERT_LT(complex.vertex(4 * c + i), complex.vertex(4 * c + i + 1));
      if (c == 0) continue;
      ASSERT_TRUE(std::lexicographical_compare(&complex.vertex(4 * c - 4), &complex.vertex(4 * c),
                                               &complex.vertex(4 * c), &complex.vertex(4 * c) + 4));
    }
  }
}

TEST(Delaunay, outward_facets_of_finite_cells_turn_outwards_and_cells_fill_the_convex_hull) {
  for (const auto& points : clouds()) {
    const DelaunayComplex complex = complex_of(cloud_of(points));
    double cells_volume = 0;
    double hull_volume = 0;
    for (std::size_t c = 0; c < complex.cells(); ++c) {
      if (complex.infinite(CellIndex(c))) continue;
      EXPECT_GT(signed_volume_of(complex, c), -kRounding);
      cells_volume += signed_volume_of(complex, c);
      for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
        const auto [p, q, r] = complex.outward_facet(SideIndex(s));
        const Point3& o = complex.positions[complex.vertex(s)];
        const double height = dot(complex.positions[p] - o, cross(complex.positions[q] - o, complex.positions[r] - o));
        EXPECT_GT(height, -kRounding);
        if (complex.infinite(complex.neighbour(SideIndex(s)))) {
          hull_volume += dot(complex.positions[p], cross(complex.positions[q], complex.positions[r])) / 6;
        }
      }
    }
    EXPECT_NEAR(cells_volume, hull_volume, 1e-9 * cells_volume);
  }
}

TEST(Delaunay, stars_list_every_corner_once) {
  for (const auto& points : clouds()) {
    const DelaunayComplex complex = complex_of(cloud_of(points));
    std::size_t corners = 0;
    for (std::size_t v = 0; v < complex.points(); ++v) {
      const auto star = complex.star(VertexIndex(v));
      corners += star.size();
      EXPECT_TRUE(std::ranges::is_sorted(star));
      for (const SideIndex corner : star) ASSERT_EQ(complex.vertex(corner), VertexIndex(v));
    }
    std::size_t infinite = 0;
    for (std::size_t c = 0; c < complex.cells(); ++c) infinite += complex.infinite(CellIndex(c)) ? 1U : 0U;
    EXPECT_EQ(corners + infinite, 4 * complex.cells());
  }
}

TEST(Delaunay, has_the_euler_characteristic_of_the_3_sphere) {
  for (const auto& points : clouds()) {
    const DelaunayComplex complex = complex_of(cloud_of(points));
    std::set<VertexIndex> hull;
    for (std::size_t c = 0; c < complex.cells(); ++c) {
      if (!complex.infinite(CellIndex(c))) continue;
      for (std::size_t i = 0; i < 3; ++i) hull.insert(complex.vertex(4 * c + i));
    }
    const std::size_t edges = number_edges(complex, 1).edges() + hull.size();
    EXPECT_EQ(edges, complex.points() + 1 + complex.cells());
  }
}

TEST(Delaunay, numbers_every_edge_once_by_its_ends_for_any_number_of_threads) {
  for (const auto& points : clouds()) {
    const DelaunayComplex complex = complex_of(cloud_of(points));
    std::set<std::pair<VertexIndex, VertexIndex>> edges;
    for (std::size_t c = 0; c < complex.cells(); ++c) {
      for (const auto& [a, b] : kCellEdges) {
        if (complex.vertex(4 * c + b) < complex.points()) {
          edges.insert({complex.vertex(4 * c + a), complex.vertex(4 * c + b)});
        }
      }
    }
    const EdgeNumbering numbering = number_edges(complex, 1);
    ASSERT_EQ(numbering.edges(), edges.size());
    std::size_t next = 0;
    for (const auto& [a, b] : edges) EXPECT_EQ(numbering.find(a, b), next++);
    const EdgeNumbering with_three = number_edges(complex, 3);
    EXPECT_EQ(with_three.starts, numbering.starts);
    EXPECT_EQ(with_three.greater, numbering.greater);
  }
}

/// Points that make predicates fail: lattices, spheres, planes with a point off them, tiny clusters far apart.
std::vector<Point3> degenerate_points(std::mt19937& random) {
  const auto below = [&](int limit) { return std::uniform_int_distribution<int>(0, limit - 1)(random); };
  const double tiny = std::ldexp(1.0, -10 * below(9));
  const int kind = below(4);
  const int side = 2 + below(4);
  std::vector<Point3> points;
  const std::vector<Point3> sphere = testing::sphere_points(8 + static_cast<std::size_t>(below(60)));
  const std::size_t count = 5 + static_cast<std::size_t>(below(120));
  for (std::size_t k = 0; k < count; ++k) {
    Point3 p{1.0 * below(side), 1.0 * below(side), 1.0 * below(side)};
    if (kind == 1) p = sphere[k % sphere.size()];
    if (kind == 2) p[2] *= below(8) == 0 ? tiny : 0;
    if (kind == 3 && below(2) == 0) p = {1 + tiny * p[0], 1 + tiny * p[1], tiny * p[2]};
    points.push_back(p);
  }
  return points;
}

TEST(Delaunay, has_the_cells_that_cgal_has_on_any_points) {
  std::mt19937 random(11);
  auto sets = clouds();
  for (int k = 0; k < 2000; ++k) sets.push_back(degenerate_points(random));
  for (const auto& points : sets) {
    const PointCloud cloud = cloud_of(points);
    Context context;
    const auto ours = delaunay_complex(cloud, context, 1);
    const auto cgals = delaunay_complex(cloud, context, 1, triangulate_with_cgal);
    ASSERT_EQ(ours.ok(), cgals.ok());
    if (!ours) {
      EXPECT_EQ(ours.error().code, cgals.error().code);
      EXPECT_EQ(ours.error().detail, cgals.error().detail);
      continue;
    }
    EXPECT_EQ(ours->table, cgals->table);
    EXPECT_EQ(ours->mirrored, cgals->mirrored);
  }
}

TEST(Delaunay, no_point_lies_in_the_ball_of_a_cell) {
  const DelaunayComplex complex = complex_of(cloud_of(testing::random_points(120, 5)));
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    if (complex.infinite(CellIndex(c))) continue;
    const Point3 o = complex.positions[complex.vertex(4 * c)];
    const auto edge = [&](std::size_t i) { return complex.positions[complex.vertex(4 * c + i)] - o; };
    const Point3 a = edge(1);
    const Point3 b = edge(2);
    const Point3 d = edge(3);
    Point3 centre{};
    for (std::size_t k = 0; k < 3; ++k) {
      centre[k] = (dot(a, a) * cross(b, d)[k] + dot(b, b) * cross(d, a)[k] + dot(d, d) * cross(a, b)[k]) /
                  (2 * dot(a, cross(b, d)));
    }
    for (const Point3& p : complex.positions) EXPECT_GE(norm(p - o - centre), norm(centre) * (1 - 1e-9));
  }
}

TEST(Delaunay, is_the_same_for_any_order_of_the_points_even_on_a_grid) {
  std::mt19937 random(7);
  for (auto points : {grid(6), testing::sphere_points(400), testing::random_points(9000, 6)}) {
    const DelaunayComplex expected = complex_of(cloud_of(points));
    for (int round = 0; round < 3; ++round) {
      std::ranges::shuffle(points, random);
      const DelaunayComplex complex = complex_of(cloud_of(points), 2);
      EXPECT_TRUE(complex.table == expected.table);
      EXPECT_EQ(complex.mirrored, expected.mirrored);
      EXPECT_EQ(complex.stars, expected.stars);
    }
  }
}

TEST(Delaunay, scales_by_powers_of_two_alone_and_keeps_the_cells) {
  const std::vector<Point3> points = testing::random_points(100, 8);
  const DelaunayComplex expected = complex_of(cloud_of(points));
  for (const int exponent : {-90, -3, 5, 100}) {
    std::vector<Point3> scaled = points;
    for (Point3& p : scaled) {
      for (double& x : p) x = std::ldexp(x, exponent);
    }
    const DelaunayComplex complex = complex_of(cloud_of(scaled));
    EXPECT_TRUE(complex.table == expected.table);
    EXPECT_EQ(complex.positions, expected.positions);
    EXPECT_EQ(complex.scale, std::ldexp(expected.scale, -exponent));
  }
}

TEST(Delaunay, points_that_would_lose_bits_are_not_scaled) {
  const std::vector<Point3> points{{1e38, 0, 0}, {0, 1e38, 0}, {0, 0, 1e38}, {0, 0, 0}, {5e-324, 0, 0}};
  const DelaunayComplex complex = complex_of(cloud_of(points));
  EXPECT_EQ(complex.scale, 1);
  EXPECT_EQ(complex.points(), 5U);
}

TEST(Delaunay, flat_input_is_refused_by_name_and_count) {
  std::string detail;
  EXPECT_EQ(error_of({}, &detail), ErrorCode::too_few_points);
  EXPECT_EQ(error_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}}, &detail), ErrorCode::too_few_points);
  EXPECT_THAT(detail, ::testing::HasSubstr("3 distinct points"));
  EXPECT_EQ(error_of({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {-4, -4, -4}, {3, 3, 3}}, &detail), ErrorCode::collinear);
  EXPECT_THAT(detail, ::testing::HasSubstr("5 distinct points"));
  EXPECT_EQ(error_of({{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {3, 7, 1}, {5, 5, 1}}, &detail), ErrorCode::coplanar);
  EXPECT_THAT(detail, ::testing::HasSubstr("6 distinct points"));
}

TEST(Delaunay, the_least_deviation_from_a_plane_is_not_flat) {
  EXPECT_EQ(error_of({{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, std::nextafter(1.0, 2.0)}}), ErrorCode::internal_error);
}

TEST(Delaunay, stops_when_cancelled) {
  const std::atomic<bool> cancel{true};
  Context context(1, {}, &cancel);
  const auto complex = delaunay_complex(cloud_of(testing::random_points(100, 9)), context, 1);
  ASSERT_FALSE(complex);
  EXPECT_EQ(complex.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace surfaced
