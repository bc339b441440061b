// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: the edge collapses.
#pragma once

#include <vector>

#include "base/cancelled.hpp"
#include "simplification/simplification.hpp"

namespace surfaced::simplification {

/// When to stop; whichever comes first.
struct Stop {
  std::size_t triangles = 0;
  /// Root of the quadric error of the next collapse, in units of the input.
  double error = 0;
};

/// What the collapses report of the stage's progress; the rest is for measuring the distance.
constexpr double kShareOfCollapses = 0.6;

/// Positions and triangles, and for every vertex the one of the input that it is, if no collapse touched it.
struct Collapsed {
  TriangleMesh mesh;
  std::vector<VertexIndex> untouched;
};

/// @pre  an oriented manifold, edges and vertices.
/// @throws Cancelled
Collapsed collapse(const TriangleMesh& mesh, const Stop& stop, Context& context);

}  // namespace surfaced::simplification
