// SPDX-License-Identifier: GPL-3.0-or-later
// The order in which points are inserted into a Delaunay triangulation.
#pragma once

#include <cstdint>
#include <vector>

namespace surfaced {

/// Biased randomised insertion order (Amenta, Choi, Rote 2003): rounds of growing size, each in the
/// cloud's own Morton order, forwards and backwards in turn. The cloud is sorted already, so this costs no sorting.
std::vector<std::uint32_t> insertion_order(std::size_t count);

}  // namespace surfaced
