// SPDX-License-Identifier: GPL-3.0-or-later
// The steps of the paper in the paper's order (Figure 12), and lids of any kind for them.
#pragma once

#include "base/context.hpp"
#include "minimum_boundary/boundary_complex.hpp"
#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/hole_covering.hpp"
#include "minimum_boundary/labelling.hpp"
#include "minimum_boundary/minimum_boundary.hpp"

namespace surfaced::boundary {

/// What is read by all steps.
struct LidCase {
  const DelaunayComplex& complex;
  const BoundaryComplex& boundary;
  const Criterion& criterion;
  const MinimumBoundaryParameters& parameters;
};

/// BC with the lids that the parameters name; the watershed has none, for it the paper's. `labels` are the cells
/// already taken in. Writes what it covered to the statistics.
/// @return  cancelled.
Result<Covered> cover(const LidCase& c, const Labelling& labels, MinimumBoundaryStatistics& statistics,
                      Context& context);

/// Conforming, hole covering, inflating, sculpturing. Precondition as for `inflate`. Writes the counts of each step to
/// the statistics.
/// @return  cancelled.
Result<Labelling> papers_way(const LidCase& c, MinimumBoundaryStatistics& statistics, Context& context);

}  // namespace surfaced::boundary
