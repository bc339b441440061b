// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: what CGAL puts into a hole.
#pragma once

#include <optional>

#include "hole_filling/patch.hpp"

namespace surfaced::filling {

/// Covers the hole by the library: least area and bend, refined to the edge lengths of the boundary (Liepa 2003). Where
/// an edge between two corners exists in the mesh already, it gets a vertex in its middle.
/// @return  the patch; none if the library finds none.
/// @cost    usually O(n log n) for n corners, at worst O(n³).
std::optional<Patch> cover_by_library(const Hole& hole);

}  // namespace surfaced::filling
