// SPDX-License-Identifier: GPL-3.0-or-later
// The hull of a set of facets (§5.2): what can be reached from outside without passing through it.
#pragma once

#include <cstdint>
#include <vector>

#include "minimum_boundary/boundary_complex.hpp"

namespace surfaced::boundary {

/// Per cell 1 if no way leads from the infinite cells to it that crosses no facet of `walls` (inside the
/// hull or between its sheets), else 0.
/// @cost  O(cells).
std::vector<std::uint8_t> cells_behind(const DelaunayComplex& complex, const FacetSet& walls);

}  // namespace surfaced::boundary
