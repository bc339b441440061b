// SPDX-License-Identifier: GPL-3.0-or-later
// The surfaces of paper 3's tables and figures.
#pragma once

#include <map>
#include <utility>

#include "support/shapes.hpp"

namespace surfaced::testing {

/// An icosahedron whose triangles are split into four `levels` times, on the unit sphere: 10·4^levels + 2 vertices.
inline TriangleMesh icosphere(int levels) {
  const auto on_sphere = [](const Point3& p) {
    const double length = norm(p);
    return Point3{p[0] / length, p[1] / length, p[2] / length};
  };
  const double golden = (1 + std::sqrt(5.0)) / 2;
  TriangleMesh mesh;
  for (const Point3& p : {Point3{-1, golden, 0},
                          {1, golden, 0},
                          {-1, -golden, 0},
                          {1, -golden, 0},
                          {0, -1, golden},
                          {0, 1, golden},
                          {0, -1, -golden},
                          {0, 1, -golden},
                          {golden, 0, -1},
                          {golden, 0, 1},
                          {-golden, 0, -1},
                          {-golden, 0, 1}})
    mesh.positions.push_back(on_sphere(p));
  for (const std::array<int, 3>& f :
       {std::array{0, 11, 5}, {0, 5, 1},  {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2},
        {10, 7, 6},           {7, 1, 8},  {3, 9, 4}, {3, 4, 2},  {3, 2, 6},   {3, 6, 8}, {3, 8, 9},  {4, 9, 5},
        {2, 4, 11},           {6, 2, 10}, {8, 6, 7}, {9, 8, 1}})
    mesh.triangles.push_back(
        triangle(static_cast<std::size_t>(f[0]), static_cast<std::size_t>(f[1]), static_cast<std::size_t>(f[2])));
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> middles;
    const auto middle = [&](VertexIndex a, VertexIndex b) {
      const auto [known, is_new] = middles.try_emplace(std::minmax<std::size_t>(a, b), mesh.positions.size());
      if (is_new) {
        const Point3& p = mesh.positions[a];
        const Point3& q = mesh.positions[b];
        mesh.positions.push_back(on_sphere({p[0] + q[0], p[1] + q[1], p[2] + q[2]}));
      }
      return known->second;
    };
    std::vector<Triangle> finer;
    for (const Triangle& t : mesh.triangles) {
      const std::size_t x = middle(t[0], t[1]);
      const std::size_t y = middle(t[1], t[2]);
      const std::size_t z = middle(t[2], t[0]);
      for (const Triangle& f : {triangle(t[0], x, z), triangle(t[1], y, x), triangle(t[2], z, y), triangle(x, y, z)})
        finer.push_back(f);
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

/// Points of a tube around the trefoil knot (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t), every other ring turned by
/// half a step; `along` has to be even.
inline std::vector<Point3> knot_points(std::size_t along, std::size_t around, double tube) {
  std::vector<Point3> points;
  const auto unit = [](const Point3& p) {
    const double length = norm(p);
    return Point3{p[0] / length, p[1] / length, p[2] / length};
  };
  for (std::size_t i = 0; i < along; ++i) {
    const double t = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(along);
    const Point3 centre{std::sin(t) + 2 * std::sin(2 * t), std::cos(t) - 2 * std::cos(2 * t), -std::sin(3 * t)};
    const Point3 first{std::cos(t) + 4 * std::cos(2 * t), -std::sin(t) + 4 * std::sin(2 * t), -3 * std::cos(3 * t)};
    const Point3 second{-std::sin(t) - 8 * std::sin(2 * t), -std::cos(t) + 8 * std::cos(2 * t), 9 * std::sin(3 * t)};
    const Point3 binormal = unit(cross(first, second));
    const Point3 normal = cross(binormal, unit(first));
    for (std::size_t j = 0; j < around; ++j) {
      const double a = 2 * std::numbers::pi * (static_cast<double>(j) + 0.5 * static_cast<double>(i % 2)) /
                       static_cast<double>(around);
      Point3 p = centre;
      for (std::size_t k = 0; k < 3; ++k) p[k] += tube * (std::cos(a) * normal[k] + std::sin(a) * binormal[k]);
      points.push_back(p);
    }
  }
  return points;
}

}  // namespace surfaced::testing
