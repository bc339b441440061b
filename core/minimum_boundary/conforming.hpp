// SPDX-License-Identifier: GPL-3.0-or-later
// Orientable artifacts (§6.1): inflates selectively until the deflated parts of the hull conform.
#pragma once

#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/walled_star.hpp"

namespace surfaced::boundary {

/// The paper's conditions around one vertex: the outside meets it on at most two sides; each deflated edge
/// there separates exactly two sides of the outside; one side sees all deflated edges; and a vertex that is
/// deflated is so in an edge.
bool conforms(const Walls& walls, WalledStar& star, VertexIndex v);

/// Takes cells in, cheapest first, at vertices that do not conform.
/// @return  number of cells taken in; cancelled.
Result<std::size_t> make_conforming(Labelling& labels, const FacetSet& facets, const Criterion& criterion,
                                    const Context& context);

}  // namespace surfaced::boundary
