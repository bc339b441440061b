// SPDX-License-Identifier: GPL-3.0-or-later
// The paper's "curv": how much absolute mean curvature edge flips could still remove (§8, Table 1).
#pragma once

#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

/// K = Σ over edges of |angle between the normals| times length.
/// @param labels  a copy is flipped where that lowers K and is legal (Theorem C): one pass over the cells of
///                which that holds at the beginning.
/// @return        100 (1 - K'/K), K' after the flips; 0 where K is 0. Reported, never used.
double curvature_reduction(Labelling labels, unsigned threads);

}  // namespace surfaced::boundary
