// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: a hole, and what is put into it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/base.hpp"

namespace surfaced::filling {

using Corners = std::array<std::uint32_t, 3>;

/// The surroundings of a hole of n corners, the hole to the left of edge i -> i+1.
struct Hole {
  std::vector<Point3> corners;
  /// Normals of the mesh at the corners, weighted by its angles there: the longer, the more of the full turn it has.
  std::vector<Point3> normals;
  /// Third vertex of the face beyond edge i -> i+1.
  std::vector<Point3> beyond;
  /// How long new edges shall be at the corners.
  std::vector<double> spacings;
  /// Whether the mesh joins two corners already.
  std::function<bool(std::uint32_t, std::uint32_t)> joined;
};

/// A triangulated disc whose boundary is the hole's: points 0..n-1 are its corners, then come new ones. Triangles are
/// oriented like the edges i -> i+1; no edge between corners i, j with joined(i, j) other than those of the hole.
struct Patch {
  std::vector<Point3> points;
  std::vector<Corners> triangles;
};

}  // namespace surfaced::filling
