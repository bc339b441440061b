// SPDX-License-Identifier: GPL-3.0-or-later
// Planes and quadrics through a handful of points.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "base/geometry.hpp"

namespace surfaced {

/// Unit normal of the plane that fits the points best; its side is arbitrary. None where they have no extent.
std::optional<Point3> normal_of_plane(std::span<const Point3> points);

/// A quadric at the first of the points it was fitted to.
struct Jet {
  /// The first point projected onto the quadric.
  Point3 origin;
  /// Of length 1; its side is arbitrary.
  Point3 normal;
  /// Principal curvatures, in units of 1 / length; 0 unless asked for.
  std::array<double, 2> curvatures{};
};

/// How much of a jet is wanted; less costs less.
enum class JetForm { normal, curvatures };

/// The jet of degree 2 at the first of the points. None where they determine none: fewer than 6, several in one place
/// up to rounding, all on a line.
std::optional<Jet> jet_of(std::span<const Point3> points, JetForm form);

/// Principal curvatures at the first of the points, in units of 1 / length, larger first: those of jet_of, for
/// less. None as there.
std::optional<std::array<double, 2>> principal_curvatures(std::span<const Point3> points);

}  // namespace surfaced
