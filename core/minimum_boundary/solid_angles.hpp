// SPDX-License-Identifier: GPL-3.0-or-later
// How much of the space around each vertex lies inside: tells a body from a ribbon that covers it on both sides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

/// Vertices by the share of a small sphere around them that lies inside; about a half on a body.
struct SolidAngles {
  std::size_t vertices = 0;
  /// Less than a tenth inside: both sides of a thin sheet, or the tip of a needle.
  std::size_t thin = 0;
  /// More than four fifths inside: the bottom of a pocket.
  std::size_t buried = 0;
  /// Per point 1 if it is thin or buried.
  std::vector<std::uint8_t> pointed;
  /// Share of thin vertices that tells a hollow cage: 16 to 39 % on cages, at most 8 % on thin and sparse bodies.
  static constexpr double kHollowShare = 0.12;
  /// Below so many vertices arms and ears are a large part of a body, and it takes a larger share to tell.
  static constexpr std::size_t kFewVertices = 300;
  static constexpr double kHollowShareOfFew = 0.25;
  static double cage_share(std::size_t vertices) { return vertices < kFewVertices ? kHollowShareOfFew : kHollowShare; }
  double thin_share() const { return vertices == 0 ? 0 : static_cast<double>(thin) / static_cast<double>(vertices); }
};

/// @cost  O(facets), a walk around an edge and an arc tangent for each edge and end.
SolidAngles solid_angles(const Labelling& labels, unsigned threads);

}  // namespace surfaced::boundary
