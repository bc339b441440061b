// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room.
#pragma once

#include <optional>

#include "hole_filling/patch.hpp"

namespace surfaced::filling {

/// Covers the hole by paper 3's advancing front (§3.3, figure 2): at the front vertex with the smallest angle one, two
/// or three triangles.
/// @param most_points  how many new points it may take.
/// @return  the patch; none if the front stops, or after the larger of n² and most_points + n steps.
std::optional<Patch> cover_by_angles(const Hole& hole, std::size_t most_points);

}  // namespace surfaced::filling
