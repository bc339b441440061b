// SPDX-License-Identifier: GPL-3.0-or-later
// Lids by a minimal cut: the cheapest set of facets that parts what is surely inside from infinity.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "minimum_boundary/hole_covering.hpp"

namespace surfaced::boundary {

/// Per cell 1 if it lies behind the cut, else 0. The facets outside `boundary` between these cells and the others
/// have the least Σλ of all sets of facets that, together with `boundary`, part the seeds from the infinite cells;
/// among equal ones it is the set nearest to infinity, which is unique.
/// @param seeds  per cell nonzero where it has to lie behind the cut; no infinite cell.
/// @return       cancelled.
/// @cost         a maximal flow through the dual graph: in practice a few times the Delaunay triangulation,
///               without a useful bound; 150 bytes per cell.
Result<std::vector<std::uint8_t>> cells_behind_cut(const DelaunayComplex& complex, const FacetSet& boundary,
                                                   const Criterion& criterion, const std::vector<std::uint8_t>& seeds,
                                                   const Context& context);

/// BC with the facets of a minimal cut. Seeds are cells that lids of ball ratio `delta` keep from the outside and
/// whose balls are large against the spacing of the boundary complex at their vertices. Tries seeds of several
/// sizes, and without delta both ends of the ladder's sound part; keeps the cut that leaves the fewest points
/// outside, inside or pinched.
/// @return  cancelled.
Result<Covered> cover_by_cut(const DelaunayComplex& complex, const FacetSet& boundary, const Criterion& criterion,
                             std::optional<double> delta, Context& context);

}  // namespace surfaced::boundary
