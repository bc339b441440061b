// SPDX-License-Identifier: GPL-3.0-or-later
// The two exact predicates of Delaunay triangulation: a filter in double here, CGAL's exact ones where it fails.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "base/base.hpp"

namespace surfaced::predicates {

/// CGAL's exact predicates, filtered by interval arithmetic first.
int exact_orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d);
int exact_side_of_sphere(const Point3& a, const Point3& b, const Point3& c, const Point3& d, const Point3& p);
bool collinear(const Point3& a, const Point3& b, const Point3& c);

/// Largest magnitudes of the coordinates of some vectors, axis by axis; static error bounds grow with them
/// (Meyer, Pion 2008, as in CGAL).
class Extent {
 public:
  void add(double x, double y, double z) {
    x_ = std::max(x_, std::abs(x));
    y_ = std::max(y_, std::abs(y));
    z_ = std::max(z_, std::abs(z));
  }
  double product() const { return x_ * y_ * z_; }
  double least() const { return std::min({x_, y_, z_}); }
  double greatest() const { return std::max({x_, y_, z_}); }

 private:
  double x_ = 0;
  double y_ = 0;
  double z_ = 0;
};

/// Sign of the determinant of b-a, c-a, d-a: 1 for a positively oriented tetrahedron, 0 if all lie in a plane.
inline int orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  // Error of the determinant over the product of the extents; and where neither that product nor the
  // determinant can leave the range of double.
  constexpr double kError = 5.1107127829973299e-15;
  constexpr double kLeast = 1e-97;
  constexpr double kGreatest = 1e102;
  const double bx = b[0] - a[0], by = b[1] - a[1], bz = b[2] - a[2];
  const double cx = c[0] - a[0], cy = c[1] - a[1], cz = c[2] - a[2];
  const double dx = d[0] - a[0], dy = d[1] - a[1], dz = d[2] - a[2];
  const double xy = bx * cy - cx * by;
  const double xz = bx * dy - dx * by;
  const double yz = cx * dy - dx * cy;
  const double determinant = xy * dz - xz * cz + yz * bz;
  Extent extent;
  extent.add(bx, by, bz);
  extent.add(cx, cy, cz);
  extent.add(dx, dy, dz);
  const double error = kError * extent.product();
  if (extent.least() >= kLeast && extent.greatest() < kGreatest) {
    if (determinant > error) return 1;
    if (determinant < -error) return -1;
  }
  return exact_orientation(a, b, c, d);
}

/// 1 if p lies inside the sphere through a, b, c, d, -1 outside, 0 on it.
/// Precondition: orientation(a, b, c, d) is 1.
inline int side_of_sphere(const Point3& a, const Point3& b, const Point3& c, const Point3& d, const Point3& p) {
  // CGAL's bound is this constant times the extents x, y, z and the square of the greatest of them; no extent
  // exceeds the longest vector, so its fifth power will do, which is cheaper. Within the limits of the squared length
  // neither that power nor what underflows in the determinant matters.
  constexpr double kError = 1.2466136531027298e-13;
  constexpr double kLeast = 1e-100;
  constexpr double kGreatest = 1e100;
  const double ax = a[0] - p[0], ay = a[1] - p[1], az = a[2] - p[2];
  const double bx = b[0] - p[0], by = b[1] - p[1], bz = b[2] - p[2];
  const double cx = c[0] - p[0], cy = c[1] - p[1], cz = c[2] - p[2];
  const double dx = d[0] - p[0], dy = d[1] - p[1], dz = d[2] - p[2];
  const double aa = ax * ax + ay * ay + az * az;
  const double bb = bx * bx + by * by + bz * bz;
  const double cc = cx * cx + cy * cy + cz * cz;
  const double dd = dx * dx + dy * dy + dz * dz;
  // The determinant of the rows a, c, b, d, expanded column by column: CGAL's bound holds for this order.
  const double ac = ax * cy - cx * ay;
  const double ab = ax * by - bx * ay;
  const double ad = ax * dy - dx * ay;
  const double cb = cx * by - bx * cy;
  const double cd = cx * dy - dx * cy;
  const double bd = bx * dy - dx * by;
  const double acb = ac * bz - ab * cz + cb * az;
  const double acd = ac * dz - ad * cz + cd * az;
  const double abd = ab * dz - ad * bz + bd * az;
  const double cbd = cb * dz - cd * bz + bd * cz;
  const double determinant = acb * dd - acd * bb + abd * cc - cbd * aa;
  const double longest = std::max(std::max(aa, bb), std::max(cc, dd));
  const double error = kError * (longest * longest) * std::sqrt(longest);
  if (longest >= kLeast && longest < kGreatest) {
    if (determinant > error) return 1;
    if (determinant < -error) return -1;
  }
  return exact_side_of_sphere(a, b, c, d, p);
}

/// The same after a symbolic perturbation of the points that depends on their lexicographical order only
/// (Devillers, Teillaud 2003): never 0.
int perturbed_side_of_sphere(const std::array<Point3, 4>& cell, const Point3& p);

/// 1 if p lies inside the circle through a, b, c, -1 outside, perturbed likewise. Precondition: all in one plane.
int perturbed_side_of_circle(const std::array<Point3, 3>& facet, const Point3& p);

}  // namespace surfaced::predicates
