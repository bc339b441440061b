// SPDX-License-Identifier: GPL-3.0-or-later
// Sculpturing from in- and outside (§5.5, Figure 10) with the rule against local minima (§6.3).
#pragma once

#include <cstdint>
#include <vector>

#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/walled_star.hpp"

namespace surfaced::boundary {

struct Sculptured {
  /// Cells of the inside hull I(BC) before sculpturing.
  std::size_t core = 0;
  std::size_t exposed = 0;
  std::size_t flipped = 0;
  /// Cells between the two hulls that neither could take; they stay inside.
  std::size_t left = 0;
};

/// Cells of the inside hull I(BC): of the spaces between the walls those across the single umbrella of a vertex that
/// also meets the outside; where there are none, the largest space unless it is a single cell.
/// @return  per cell 1 if it belongs to it.
std::vector<std::uint8_t> inside_hull(const Labelling& labels, const FacetSet& walls);

/// Outside and core take the cells between them by the rules of Figure 10, the cell with the longest facet to
/// be removed first, none whose facet of least circumradius would be removed.
/// Precondition: every vertex is good; it stays so, and topology stays the same.
/// @return  cancelled.
Result<Sculptured> sculpture(Labelling& labels, const FacetSet& walls, const Criterion& criterion,
                             const Context& context);

}  // namespace surfaced::boundary
