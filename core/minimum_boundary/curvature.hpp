// SPDX-License-Identifier: GPL-3.0-or-later
// Edge flips that lower the absolute mean curvature, and the paper's "curv": how much they remove (§8, Table 1).
#pragma once

#include <cstddef>

#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

/// K = Σ over edges of |angle between the normals| times length.
struct Straightened {
  double curvature = 0;
  double removed = 0;
  std::size_t flipped = 0;
  /// The paper's "curv".
  double percent() const { return curvature > 0 ? 100 * removed / curvature : 0; }
};

/// Flips edges where that lowers K and is legal (Theorem C), so that vertices stay good and topology stays: in every
/// round once over the cells of which it held at its beginning, the first time over all.
/// @param stretch  an edge gives way to one at most so many times as long.
/// @param rounds   at most so many; few are needed.
/// @cost  O(cells), then in proportion to the flips.
Straightened straighten(Labelling& labels, double stretch, unsigned rounds, unsigned threads);

/// What the first round would remove, in percent of K.
double curvature_reduction(Labelling labels, unsigned threads);

}  // namespace surfaced::boundary
