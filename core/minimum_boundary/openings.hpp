// SPDX-License-Identifier: GPL-3.0-or-later
// Openings kept: what spans them is cut out of the closed surface.
#pragma once

#include <cstddef>

#include "mesh/mesh.hpp"

namespace surfaced::boundary {

/// Removes the sheets (measures.hpp) but those without which a vertex would have several fans: there all but the widest
/// gap stay closed.
/// Precondition: closed, oriented, vertex-manifold. Afterwards oriented and vertex-manifold, with a boundary, every
/// vertex used that was.
/// @return  number of triangles removed.
/// @cost    O(triangles) in each of a few rounds.
std::size_t cut_openings(TriangleMesh& mesh);

}  // namespace surfaced::boundary
