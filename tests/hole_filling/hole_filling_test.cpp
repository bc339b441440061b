// SPDX-License-Identifier: GPL-3.0-or-later
#include "hole_filling/hole_filling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace surfaced {
namespace {

/// A convex polygon in the plane z = 0 with faces going on flat beyond its edges.
Loop flat_polygon(std::size_t n) {
  Loop loop;
  for (std::size_t i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    const double m = a + std::numbers::pi / static_cast<double>(n);
    loop.corners.push_back({std::cos(a), std::sin(a), 0});
    loop.beyond.push_back({2 * std::cos(m), 2 * std::sin(m), 0});
  }
  return loop;
}

double area(const Loop& loop, const std::array<std::uint32_t, 3>& t) {
  const Point3& a = loop.corners[t[0]];
  return norm(cross(loop.corners[t[1]] - a, loop.corners[t[2]] - a)) / 2;
}

TEST(TriangulateLoop, fills_a_polygon_with_two_triangles_less_than_corners_all_facing_like_the_rim) {
  for (const std::size_t n : {3U, 4U, 7U, 30U}) {
    const Loop loop = flat_polygon(n);
    const auto triangles = triangulate_loop(loop, {});
    ASSERT_TRUE(triangles);
    EXPECT_EQ(triangles->size(), n - 2);
    double sum = 0;
    for (const auto& t : *triangles) {
      EXPECT_TRUE(t[0] < t[1] && t[1] < t[2]);
      sum += area(loop, t);
    }
    EXPECT_NEAR(sum, static_cast<double>(n) / 2 * std::sin(2 * std::numbers::pi / static_cast<double>(n)), 1e-12);
  }
}

/// Least area over all triangulations of corners i..j, by trying them all.
double least_area(const Loop& loop, std::uint32_t i, std::uint32_t j) {
  if (j == i + 1) return 0;
  double best = std::numeric_limits<double>::infinity();
  for (std::uint32_t k = i + 1; k < j; ++k) {
    best = std::min(best, least_area(loop, i, k) + least_area(loop, k, j) + area(loop, {i, k, j}));
  }
  return best;
}

TEST(TriangulateLoop, has_the_least_area_of_all_triangulations_where_bends_are_free) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (int round = 0; round < 50; ++round) {
    Loop loop = flat_polygon(8);
    for (Point3& p : loop.corners) p[2] += coordinate(random);
    const auto triangles = triangulate_loop(loop, {.least_cosine = -1, .may_join = {}});
    ASSERT_TRUE(triangles);
    double sum = 0;
    for (const auto& t : *triangles) sum += area(loop, t);
    EXPECT_NEAR(sum, least_area(loop, 0, 7), 1e-12);
  }
}

TEST(TriangulateLoop, never_joins_corners_that_may_not_be_joined) {
  const Loop loop = flat_polygon(4);
  const auto not_02 = [](std::size_t i, std::size_t j) { return !(i == 0 && j == 2); };
  const auto triangles = triangulate_loop(loop, {.least_cosine = -1, .may_join = not_02});
  ASSERT_TRUE(triangles);
  for (const auto& t : *triangles) EXPECT_TRUE(t[0] != 0 || t[1] == 1 || t[2] == 3);
  EXPECT_FALSE(
      triangulate_loop(loop, {.least_cosine = -1, .may_join = [](std::size_t, std::size_t) { return false; }}));
}

TEST(TriangulateLoop, refuses_to_fold_back_over_the_faces_beyond) {
  Loop loop = flat_polygon(3);
  for (Point3& p : loop.beyond) p = {0, 0, 0.01};  // nearly the triangle itself, on its other side
  EXPECT_FALSE(triangulate_loop(loop, {}));
  EXPECT_FALSE(triangulate_loop(flat_polygon(2), {}));
}

}  // namespace
}  // namespace surfaced
