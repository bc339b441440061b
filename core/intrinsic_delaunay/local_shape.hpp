// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "base/base.hpp"

namespace surfaced::idt {

/// A piece of surface as a height over its tangent plane: z = c0 + c1 x + c2 y + c3 x² + c4 xy + c5 y², the jet of
/// degree 2, in a frame at an origin.
struct LocalShape {
  Point3 origin{};
  /// Orthonormal, right-handed; the third vector is the upward normal.
  std::array<Point3, 3> frame{};
  std::array<double, 6> c{};

  /// The point of the surface above or below p.
  Point3 above(const Point3& p) const;
  /// Mean and Gaussian curvature there; a sphere whose normals point outwards has a negative mean.
  struct Curvature {
    double mean = 0;
    double gaussian = 0;
  };
  Curvature curvature_at(const Point3& p) const;
};

/// Fits by least squares, in a frame of the points' principal axes whose normal agrees with `up`. Points that allow no
/// quadric give their plane.
/// @return  none for fewer than 3 points or points on a line.
std::optional<LocalShape> fit_shape(std::span<const Point3> points, const Point3& origin, const Point3& up);

}  // namespace surfaced::idt
