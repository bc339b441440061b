// SPDX-License-Identifier: GPL-3.0-or-later
// Openings of a scanned surface that triangles were drawn across.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/mesh.hpp"

namespace surfaced {

/// A connected set of triangles that span an opening.
struct SpannedOpening {
  /// Ascending.
  std::vector<std::uint32_t> triangles;
  double longest_edge = 0;
};

/// The triangles of the list in sets that are connected across edges, each ascending if the list is, in the order of
/// their first.
/// @cost  O(n log n).
std::vector<std::vector<std::uint32_t>> sets_across_edges(const TriangleMesh& mesh,
                                                          const std::vector<std::uint32_t>& list);

/// Sets of neighbouring triangles whose circumradii are more than three times those at all their corners and whose area
/// is that of an opening about six spacings wide, or more: of points that lie at random on a surface no gaps are so
/// large. The circumradii at a vertex are taken to be the second smallest of its triangles, so that triangles between
/// sparse and dense regions, between scan lines, and in regions that are sparse altogether are none.
/// @pre   no edge has more than two triangles.
/// @cost  O(V + F); 4 bytes per triangle, 8 per vertex.
std::vector<SpannedOpening> spanned_openings(const TriangleMesh& mesh);

/// Drops the triangles of the openings that were found; then, at vertices where several fans are left, all fans but the
/// one of most triangles; then bridges that are left between rims, until there is nothing of all this.
void open_up(TriangleMesh& mesh, const std::vector<SpannedOpening>& openings);

/// Drops triangles along the rim whose longest edge lies on it and whose circumradii are as much too large: slivers
/// that span the bays between neighbours on the rim. No vertex is left without a triangle.
/// @pre   an oriented manifold, edges and vertices.
/// @return  how many.
std::size_t peel_slivers(TriangleMesh& mesh);

}  // namespace surfaced
