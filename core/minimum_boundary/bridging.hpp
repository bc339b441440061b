// SPDX-License-Identifier: GPL-3.0-or-later
// Bridging: joins components of the surface where one was asked for.
#pragma once

#include "minimum_boundary/boundary_complex.hpp"
#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

struct Bridged {
  std::size_t components_before = 0;
  std::size_t components = 0;
};

/// While there are more components than wanted, joins the smallest one that can be joined to another along the cheapest
/// chain of cells between them (outside cells become inside; for a cavity the other way), then inflates. A
/// bridge that does not lower the number of components is taken back.
/// Precondition and postcondition: every vertex is good.
/// @return  what is left; cancelled.
/// @cost    a search and an inflation, O(cells), per bridge; nothing for one component. At most 64 bridges.
Result<Bridged> bridge(Labelling& labels, const FacetSet& boundary, const Criterion& criterion, std::size_t wanted,
                       const Context& context, unsigned threads);

}  // namespace surfaced::boundary
