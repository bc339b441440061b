// SPDX-License-Identifier: GPL-3.0-or-later
// Artifact boundaries and hull holes (§5.2, 5.3).
#pragma once

#include <vector>

#include "minimum_boundary/spaces.hpp"

namespace surfaced::boundary {

/// A sliver set: polyhedra inside H(BC), other than the inside hull, that share triangles, with the set T of their
/// triangles.
struct Artifact {
  /// Vertices of T, ascending.
  std::vector<VertexIndex> vertices;
  /// Edges of its boundary L: those of the hull H(T) at which there is another triangle of BC outside T, so more than
  /// two; each counted as often as H(T) meets it.
  std::size_t boundary_edges = 0;
  /// L does not part H(T): from one side of an edge of L a walk over triangles of H(T) that crosses no edge of L comes
  /// to the other side. Where BC folds back upon itself there is such a walk, over the fold.
  bool hull_hole = false;
};

/// All artifacts, in the order of their least cell.
/// @cost  O(cells).
std::vector<Artifact> find_artifacts(const Walls& walls);

}  // namespace surfaced::boundary
