// Closing boundary loops of a mesh. Small loops only, without new vertices.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/base.hpp"

namespace surfaced {

/// A closed boundary loop, with the hole to the left of its edges i -> i+1.
struct Loop {
  std::vector<Point3> corners;
  /// Third vertex of the face on the other side of edge i -> i+1.
  std::vector<Point3> beyond;
};

/// What a triangulation of a loop must not do.
struct LoopLimits {
  /// Least cosine of the angle between the normals of faces that share an edge, those beyond the loop included.
  double least_cosine = -0.5;
  /// Whether corners i and j may be joined; asked for pairs that are not neighbours on the loop.
  std::function<bool(std::size_t i, std::size_t j)> may_join;
};

/// Triangulates the loop with the least total area, by dynamic programming over its sub-polygons (Barequet and
/// Sharir 1995; Liepa 2003). A sub-polygon keeps its best triangulation only, so with the limit on the bend the
/// area is the least of those found, not of all.
/// @return  triangles of positions on the loop, oriented like its edges; none if the limits allow none.
/// @cost    O(n^3) time, O(n^2) memory for n corners: for loops of tens of corners.
std::optional<std::vector<std::array<std::uint32_t, 3>>> triangulate_loop(const Loop& loop, const LoopLimits& limits);

}  // namespace surfaced
