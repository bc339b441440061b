// SPDX-License-Identifier: GPL-3.0-or-later
// Arithmetic on points and vectors beyond what most rooms need.
#pragma once

#include <optional>

#include "base/geometry.hpp"

namespace surfaced {

inline Point3 operator+(const Point3& a, const Point3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Point3 operator*(double s, const Point3& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Point3& operator+=(Point3& a, const Point3& b) { return a = a + b; }

inline bool is_finite(const Point3& a) { return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]); }

/// The vector at length 1; none for one that has no direction.
inline std::optional<Point3> direction_of(const Point3& a) {
  const double length = norm(a);
  if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
  return (1 / length) * a;
}

/// v turned about the unit vector `axis` by an angle (Rodrigues), counter-clockwise seen from its tip.
inline Point3 turned(const Point3& v, const Point3& axis, double cosine, double sine) {
  return cosine * v + sine * cross(axis, v) + ((1 - cosine) * dot(axis, v)) * axis;
}

}  // namespace surfaced
