// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "mesh/mesh.hpp"

namespace surfaced {

/// The normal of the triangle, twice as long as its area.
inline Point3 area_normal(std::span<const Point3> positions, const Triangle& t) {
  return cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
}
inline Point3 area_normal(const TriangleMesh& mesh, const Triangle& t) { return area_normal(mesh.positions, t); }

/// Infinite for a triangle without area.
inline double circumradius(const TriangleMesh& mesh, const Triangle& t) {
  const Point3 normal = area_normal(mesh, t);
  const double area2 = dot(normal, normal);
  if (!(area2 > 0)) return std::numeric_limits<double>::infinity();
  const auto squared_length = [&](VertexIndex a, VertexIndex b) {
    const Point3 d = mesh.positions[b] - mesh.positions[a];
    return dot(d, d);
  };
  return std::sqrt(squared_length(t[0], t[1]) * squared_length(t[1], t[2]) * squared_length(t[2], t[0]) / area2) / 2;
}

/// At every vertex the sum over its triangles.
inline std::vector<Point3> area_normals_at_vertices(std::span<const Point3> positions,
                                                    std::span<const Triangle> triangles) {
  std::vector<Point3> normals(positions.size(), Point3{});
  for (const Triangle& t : triangles) {
    const Point3 n = area_normal(positions, t);
    for (const VertexIndex v : t) {
      for (std::size_t axis = 0; axis < 3; ++axis) normals[v][axis] += n[axis];
    }
  }
  return normals;
}

}  // namespace surfaced
