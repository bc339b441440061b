// Inflating (§6.2, Algorithm 2): makes any labelling's surface manifold by taking cells in.
#pragma once

#include <span>

#include "minimum_boundary/boundary_complex.hpp"
#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

struct Inflated {
  /// Cells taken in by the paper's rule.
  std::size_t cells = 0;
  /// Cells taken in because a vertex stayed bad without a candidate; Theorem B says that there are none.
  std::size_t forced = 0;
};

/// Moves finite OUT cells to IN, cheapest first, until every vertex is good. A candidate has a bad vertex and, at
/// that vertex, a facet of the surface or of BC; its cost is the sum of λ over its facets that are neither.
/// Precondition: the infinite cells are OUT, every vertex has a facet in `boundary`.
/// Afterwards every vertex is good (Theorem B), whatever the labels were.
/// @return  cancelled.
/// @cost    O(V) to find the bad vertices, then in proportion to the cells taken in.
Result<Inflated> inflate(Labelling& labels, const FacetSet& boundary, const Criterion& criterion,
                         const Context& context, unsigned threads);

}  // namespace surfaced::boundary
