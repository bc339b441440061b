// SPDX-License-Identifier: GPL-3.0-or-later
// The equations behind the refinement of a patch.
#include "hole_filling/laplacian.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

namespace surfaced::filling {
namespace {

/// A square of n x n points in the plane, slightly out of line, boundary points first.
Patch grid(std::uint32_t n, std::size_t& boundary) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  Patch patch;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> number;
  const auto on_rim = [&](std::uint32_t i, std::uint32_t j) { return i == 0 || j == 0 || i + 1 == n || j + 1 == n; };
  for (const bool rim : {true, false}) {
    for (std::uint32_t i = 0; i < n; ++i) {
      for (std::uint32_t j = 0; j < n; ++j) {
        if (on_rim(i, j) != rim) continue;
        number[{i, j}] = static_cast<std::uint32_t>(patch.points.size());
        patch.points.push_back({i + (rim ? 0 : shift(random)), j + (rim ? 0 : shift(random)), 0});
      }
    }
    if (rim) boundary = patch.points.size();
  }
  for (std::uint32_t i = 0; i + 1 < n; ++i) {
    for (std::uint32_t j = 0; j + 1 < n; ++j) {
      patch.triangles.push_back({number[{i, j}], number[{i + 1, j}], number[{i + 1, j + 1}]});
      patch.triangles.push_back({number[{i, j}], number[{i + 1, j + 1}], number[{i, j + 1}]});
    }
  }
  return patch;
}

TEST(Laplacian, takes_constants_to_nothing) {
  std::size_t boundary = 0;
  const Patch patch = grid(12, boundary);
  const std::vector<Point3> ones(boundary, Point3{1, -2, 1e6});
  for (const Weights weights : {cotangent_weights, belkin_weights, uniform_weights}) {
    const auto values = solve_dirichlet(patch.points.size(), weights(patch), ones, {});
    ASSERT_TRUE(values);
    for (const Point3& v : *values) {
      EXPECT_NEAR(v[0], 1, 1e-9);
      EXPECT_NEAR(v[1], -2, 1e-9);
      EXPECT_NEAR(v[2], 1e6, 1e-3);
    }
  }
}

TEST(Laplacian, keeps_harmonic_functions_within_their_values_at_the_boundary) {
  std::size_t boundary = 0;
  const Patch patch = grid(15, boundary);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> value(-1, 1);
  for (int round = 0; round < 20; ++round) {
    std::vector<Point3> known(boundary);
    for (Point3& p : known) p = {value(random), value(random), value(random)};
    for (const Weights weights : {belkin_weights, uniform_weights}) {
      const auto values = solve_dirichlet(patch.points.size(), weights(patch), known, {});
      ASSERT_TRUE(values);
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::ranges::minmax(known, {}, [k](const Point3& p) { return p[k]; });
        for (const Point3& v : *values) {
          EXPECT_GE(v[k], low[k] - 1e-12);
          EXPECT_LE(v[k], high[k] + 1e-12);
        }
      }
    }
  }
}

TEST(Laplacian, gives_linear_functions_back_with_cotangents_directly_and_by_conjugate_gradients) {
  for (const std::uint32_t n : {20U, 230U}) {  // 230² is more than the 50,000 unknowns solved directly
    std::size_t boundary = 0;
    const Patch patch = grid(n, boundary);
    const auto linear = [](const Point3& p) { return Point3{p[0], p[1] - p[0], 3 + p[1]}; };
    std::vector<Point3> known;
    for (std::size_t i = 0; i < boundary; ++i) known.push_back(linear(patch.points[i]));
    const auto values = solve_dirichlet(patch.points.size(), cotangent_weights(patch), known, {});
    ASSERT_TRUE(values);
    double worst = 0;
    for (std::size_t i = 0; i < values->size(); ++i)
      worst = std::max(worst, norm((*values)[i] - linear(patch.points[i])));
    EXPECT_LT(worst, 1e-5 * n);
  }
}

TEST(Laplacian, refuses_a_part_that_no_boundary_holds) {
  const std::vector<WeightedEdge> weights{{0, 1, 1}, {2, 3, 1}};
  const std::vector<Point3> known{{0, 0, 0}};
  EXPECT_FALSE(solve_dirichlet(4, weights, known, {}));
  EXPECT_TRUE(solve_dirichlet(2, std::span(weights).first(1), known, {}));
}

}  // namespace
}  // namespace surfaced::filling
