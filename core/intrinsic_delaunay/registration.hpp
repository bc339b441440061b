// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "intrinsic_delaunay/local_shape.hpp"

namespace surfaced::idt {

struct Aligned {
  /// The moved points.
  std::vector<Point3> points;
  /// Root of the mean squared distance from the target's points to their nearest moved points.
  double rms = 0;
};

/// Moves a patch rigidly onto another by iterated closest points: from both ways to lay its principal frame on the
/// target's, at most 10 steps of Kabsch's rotation each; the better end counts.
/// @return  none if a patch is empty or a rotation cannot be had.
std::optional<Aligned> align(std::span<const Point3> target, const LocalShape& target_shape,
                             std::span<const Point3> patch, const LocalShape& patch_shape);

}  // namespace surfaced::idt
