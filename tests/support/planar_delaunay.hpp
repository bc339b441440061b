// SPDX-License-Identifier: GPL-3.0-or-later
// Points in a tilted plane and their 2-D Delaunay triangulation by CGAL.
#pragma once

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "support/shapes.hpp"

namespace surfaced::testing {

/// Vertices of a triangle, ascending.
using Triple = std::array<std::size_t, 3>;

inline Triple sorted(std::size_t a, std::size_t b, std::size_t c) {
  Triple t{a, b, c};
  std::ranges::sort(t);
  return t;
}

/// Random points of a square of side 1, with coordinates that a tilted plane holds exactly: z = x + y/2.
inline PointCloud tilted_square(std::size_t n, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Point3> points(n);
  for (Point3& p : points) {
    const double x = std::ldexp(static_cast<double>(random() >> 6U), -26);
    const double y = std::ldexp(static_cast<double>(random() >> 6U), -26);
    p = {x, y, x + y / 2};
  }
  return *make_cloud(raw_cloud(points));
}

/// Whether the point is farther than the rim's width from the border of the square.
inline bool inside_the_rim(const Point3& p) {
  constexpr double kRim = 0.05;
  return p[0] > kRim && p[0] < 1 - kRim && p[1] > kRim && p[1] < 1 - kRim;
}

/// Triangles of a mesh over the tilted square that have a vertex inside the rim.
inline std::set<Triple> triples_inside(const TriangleMesh& mesh) {
  std::set<Triple> found;
  for (const Triangle& t : mesh.triangles) {
    if (std::ranges::any_of(t, [&](VertexIndex v) { return inside_the_rim(mesh.positions[v]); }))
      found.insert(sorted(t[0], t[1], t[2]));
  }
  return found;
}

/// The same of the 2-D Delaunay triangulation, in the plane's orthonormal frame in doubles, far more precise than
/// points in general position ask for.
inline std::set<Triple> delaunay_triples_inside(const PointCloud& cloud) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::size_t, Kernel>;
  using Structure = CGAL::Triangulation_data_structure_2<VertexBase, CGAL::Triangulation_face_base_2<Kernel>>;
  CGAL::Delaunay_triangulation_2<Kernel, Structure> plane;
  const double root2 = std::sqrt(2.0);
  const double root54 = std::sqrt(1.25 - 0.125);
  for (std::size_t v = 0; v < cloud.size(); ++v) {
    const Point3& p = cloud.positions[v];
    // e1 = (1,0,1)/sqrt 2; e2 = (0,1,1/2) - (1/4)(1,0,1) = (-1/4, 1, 1/4), length sqrt(9/8).
    const double s = (p[0] + p[2]) / root2;
    const double t = (-p[0] / 4 + p[1] + p[2] / 4) / root54;
    plane.insert(Kernel::Point_2(s, t))->info() = v;
  }
  std::set<Triple> found;
  for (auto f = plane.finite_faces_begin(); f != plane.finite_faces_end(); ++f) {
    const Triple t = sorted(f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info());
    if (std::ranges::any_of(t, [&](std::size_t v) { return inside_the_rim(cloud.positions[v]); })) found.insert(t);
  }
  return found;
}

}  // namespace surfaced::testing
