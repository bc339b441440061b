// SPDX-License-Identifier: GPL-3.0-or-later
#include "delaunay/predicates.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace surfaced::predicates {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 point(const Point3& p) { return {p[0], p[1], p[2]}; }

int plane_orientation(const Point3& a, const Point3& b, const Point3& c) {
  return Kernel().coplanar_orientation_3_object()(point(a), point(b), point(c));
}

}  // namespace

int exact_orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  return Kernel().orientation_3_object()(point(a), point(b), point(c), point(d));
}

int exact_side_of_sphere(const Point3& a, const Point3& b, const Point3& c, const Point3& d, const Point3& p) {
  return Kernel().side_of_oriented_sphere_3_object()(point(a), point(b), point(c), point(d), point(p));
}

bool collinear(const Point3& a, const Point3& b, const Point3& c) {
  return Kernel().collinear_3_object()(point(a), point(b), point(c));
}

int perturbed_side_of_sphere(const std::array<Point3, 4>& cell, const Point3& p) {
  const auto& [a, b, c, d] = cell;
  if (const int side = side_of_sphere(a, b, c, d, p); side != 0) return side;
  // The perturbation of the lexicographically greatest point decides; where its coefficient, the volume
  // that the other four span, is 0, the next one's. Two are enough.
  std::array<const Point3*, 5> points{&a, &b, &c, &d, &p};
  std::ranges::sort(points, [](const Point3* x, const Point3* y) { return *x < *y; });
  for (std::size_t i = 4; i > 2; --i) {
    int o = 0;
    if (points[i] == &p) return -1;
    if (points[i] == &d) o = orientation(a, b, c, p);
    if (points[i] == &c) o = orientation(a, b, p, d);
    if (points[i] == &b) o = orientation(a, p, c, d);
    if (points[i] == &a) o = orientation(p, b, c, d);
    if (o != 0) return o;
  }
  return -1;
}

int perturbed_side_of_circle(const std::array<Point3, 3>& facet, const Point3& p) {
  const auto& [a, b, c] = facet;
  const int side = Kernel().coplanar_side_of_bounded_circle_3_object()(point(a), point(b), point(c), point(p));
  if (side != 0) return side;
  std::array<const Point3*, 4> points{&a, &b, &c, &p};
  std::ranges::sort(points, [](const Point3* x, const Point3* y) { return *x < *y; });
  const int local = plane_orientation(a, b, c);
  for (std::size_t i = 3; i > 0; --i) {
    int o = 0;
    if (points[i] == &p) return -1;
    if (points[i] == &c) o = plane_orientation(a, b, p);
    if (points[i] == &b) o = plane_orientation(a, p, c);
    if (points[i] == &a) o = plane_orientation(p, b, c);
    if (o != 0) return o * local;
  }
  return -local;
}

}  // namespace surfaced::predicates
