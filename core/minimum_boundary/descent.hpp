// SPDX-License-Identifier: GPL-3.0-or-later
// Final descent: exposes interior vertices and flips edges while that lowers Σλ.
#pragma once

#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

struct Descent {
  std::size_t exposed = 0;
  std::size_t flipped = 0;
};

/// Moves of Figure 10 in both directions, each legal by Theorem C: OUT takes an IN cell that shows one facet
/// and whose fourth vertex is interior; IN or OUT takes a cell that shows it two facets if Σλ falls. The pair
/// (interior vertices, Σλ) falls lexicographically with every move, so it ends. Topology does not change.
/// Precondition: every vertex is good; it stays so.
/// @return  cancelled.
Result<Descent> descend(Labelling& labels, const Criterion& criterion, const Context& context, unsigned threads);

/// The change of Σλ if the cell changed its label.
std::int64_t energy_change(const Labelling& labels, const Criterion& criterion, CellIndex c);

/// Whether a flip of the cell keeps every vertex good and the topology as it is (Theorem C): it shows one
/// facet to the other label and no cell of that label touches the opposite vertex, or two facets and no cell
/// of that label touches the opposite edge.
bool flip_is_legal(const Labelling& labels, CellIndex c);

}  // namespace surfaced::boundary
