// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: which points of a file were measured.
#pragma once

#include <cstdint>
#include <vector>

#include "cloud/cloud.hpp"

namespace surfaced {

/// Turns -0 into +0, and leaves out the points without a measurement, as `missing` says.
/// @return  the rows that are left, ascending; empty if all are. Errors as of make_cloud.
/// @cost    O(N), without memory unless points are left out.
Result<std::vector<std::uint32_t>> keep_measured(RawCloud& raw, Missing missing);

}  // namespace surfaced
