// SPDX-License-Identifier: GPL-3.0-or-later
// Artifact boundaries and hull holes (§5.2, 5.3).
#pragma once

#include <vector>

#include "minimum_boundary/walled_star.hpp"

namespace surfaced::boundary {

/// A connected part of BC that is not manifold, with the ring of triangles around it.
struct Artifact {
  /// Vertices of its triangles, ascending.
  std::vector<VertexIndex> vertices;
  /// Edges of its boundaries L, each counted from every side of the hull on which it is met.
  std::size_t boundary_edges = 0;
  /// Walking on the hull inside the artifact, an edge of L is met twice: its hull is no two discs (§5.3).
  bool hull_hole = false;
};

/// All artifacts, in the order of their least vertex with u-valence above 1.
/// @cost  O(cells).
std::vector<Artifact> find_artifacts(const Walls& walls);

}  // namespace surfaced::boundary
