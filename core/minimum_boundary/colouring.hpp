// SPDX-License-Identifier: GPL-3.0-or-later
// Inside and outside by parity: clusters that the evidence sets against each other get opposite labels.
#pragma once

#include <cstdint>
#include <vector>

#include "minimum_boundary/watershed.hpp"

namespace surfaced::boundary {

/// Starts with OUT at the infinite cells and labels, one at a time, the cluster about which the labelled ones
/// agree most (weight of evidence for OUT against IN), opposite to their weighted vote; stops where the vote
/// falls below `least_vote` (in units of the ball ratio) and leaves the rest IN. Finds nested shells and capped
/// tunnels, which no flood from outside can.
/// @return  per cell 1 for IN, 0 for OUT.
/// @cost    O(cells log cells).
std::vector<std::uint8_t> parity_colouring(const DelaunayComplex& complex, const RatedFacets& rated,
                                           const Clusters& clusters, float least_vote);

}  // namespace surfaced::boundary
