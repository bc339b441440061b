// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: the canonical order of the points.
#pragma once

#include <cstdint>
#include <vector>

#include "cloud/cloud.hpp"

namespace surfaced {

struct Entry {
  std::uint64_t key;  // Morton key on the bounding cube
  std::uint32_t input;
};

/// All points by key, then by position; among equal positions by the attributes, so that means over duplicates are
/// summed in an order that the file does not decide.
/// @cost  O(N); 32 bytes per point for a moment, 16 in the result.
std::vector<Entry> canonical_order(const RawCloud& raw, unsigned threads);

}  // namespace surfaced
