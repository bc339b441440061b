// SPDX-License-Identifier: GPL-3.0-or-later
// Inflating (§6.2, Algorithm 2): makes any labelling's surface manifold by taking cells in.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

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

/// Whether a vertex needs no more cells.
using VertexTest = std::function<bool(const Labelling&, VertexIndex)>;

/// Moves finite OUT cells to IN, cheapest first, until every vertex passes the test or has no candidate left. A
/// candidate has a vertex that fails and, at that vertex, a facet of the surface or of BC; its cost is the sum of
/// λ over its facets that are neither.
/// @return  number of cells; cancelled.
/// @cost    O(V) tests to find the vertices that fail, then in proportion to the cells taken in.
Result<std::size_t> inflate_until(Labelling& labels, const FacetSet& boundary, const Criterion& criterion,
                                  const VertexTest& passes, const Context& context, unsigned threads);

/// Algorithm 2: inflates until every vertex is good.
/// Precondition: the infinite cells are OUT, every vertex has a facet in `boundary`.
/// Afterwards every vertex is good (Theorem B), whatever the labels were.
/// @return  cancelled.
Result<Inflated> inflate(Labelling& labels, const FacetSet& boundary, const Criterion& criterion,
                         const Context& context, unsigned threads);
/// The same where it is known which vertices are good: per vertex 1 if it is.
Result<Inflated> inflate_known(Labelling& labels, const FacetSet& boundary, const Criterion& criterion,
                               std::vector<std::uint8_t> good_vertices, const Context& context);

}  // namespace surfaced::boundary
