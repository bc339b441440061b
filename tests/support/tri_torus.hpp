// SPDX-License-Identifier: GPL-3.0-or-later
// A smooth surface of genus 3: three tori in a row, blended where they meet.
#pragma once

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "base/base.hpp"

namespace surfaced::testing {

/// The surface is where this is 0; negative inside.
inline double tri_torus(const Point3& p) {
  double sum = 0;
  for (const double centre : {-2.4, 0.0, 2.4}) {
    const double x = p[0] - centre;
    const double ring = std::sqrt(x * x + p[1] * p[1]) - 1;
    const double torus = std::sqrt(ring * ring + p[2] * p[2]) - 0.4;
    sum += std::exp(-8 * torus);
  }
  return -std::log(sum) / 8;
}

inline Point3 tri_torus_gradient(const Point3& p) {
  constexpr double kStep = 1e-5;
  Point3 gradient{};
  for (std::size_t k = 0; k < 3; ++k) {
    Point3 up = p;
    Point3 down = p;
    up[k] += kStep;
    down[k] -= kStep;
    gradient[k] = (tri_torus(up) - tri_torus(down)) / (2 * kStep);
  }
  return gradient;
}

/// Distance to the surface, to first order.
inline double distance_to_tri_torus(const Point3& p) { return std::abs(tri_torus(p)) / norm(tri_torus_gradient(p)); }

/// Random points on it, no two nearer than `apart`; fewer than n where no room is found.
inline std::vector<Point3> tri_torus_points(std::size_t n, double apart, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(-4, 4);
  std::uniform_real_distribution<double> y(-1.6, 1.6);
  std::uniform_real_distribution<double> z(-0.6, 0.6);
  std::vector<Point3> points;
  for (std::size_t tries = 0; points.size() < n && tries < 400 * n; ++tries) {
    Point3 p{x(random), y(random), z(random)};
    for (int i = 0; i < 20; ++i) {
      const Point3 g = tri_torus_gradient(p);
      const double step = tri_torus(p) / dot(g, g);
      for (std::size_t k = 0; k < 3; ++k) p[k] -= step * g[k];
    }
    if (!(std::abs(tri_torus(p)) < 1e-9)) continue;
    bool room = true;
    for (const Point3& q : points) room = room && norm(q - p) >= apart;
    if (room) points.push_back(p);
  }
  return points;
}

}  // namespace surfaced::testing
