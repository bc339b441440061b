// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: the boundary of a mesh as loops around its holes.
#pragma once

#include <string>
#include <vector>

#include "mesh/mesh.hpp"

namespace surfaced::filling {

/// A chain of boundary edges, begun at its least vertex, with the hole to the left of its edges i -> i+1 (so the
/// mesh has their reverses).
struct BoundaryLoop {
  std::vector<VertexIndex> corners;
  /// Third vertex of the face beyond edge i -> i+1.
  std::vector<VertexIndex> beyond;
  /// That face's half-edge i+1 -> i.
  std::vector<HalfEdgeIndex> behind;
  /// Why it cannot be filled without making the mesh non-manifold; empty if it can.
  std::string obstacle;
};

/// All loops, ascending by their least vertices. Where loops touch themselves in a vertex they are cut into simple
/// ones. A loop has an obstacle if it runs into an edge of several triangles, or if filling it and those that touch it
/// would leave several umbrellas at a vertex.
/// @cost  O(V + F).
std::vector<BoundaryLoop> boundary_loops(const TriangleMesh& mesh);

}  // namespace surfaced::filling
