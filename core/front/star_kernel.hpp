// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: the normal and the star of one point.
#pragma once

#include "front/local_stars.hpp"

namespace surfaced::front {

/// Result of the weighted principal component analysis around a point.
struct Tangent {
  Point3 normal{0, 0, 1};
  /// Smallest eigenvalue over the sum of the others, 0..0.5: how far from flat the neighbours are.
  double thickness = 0;
  /// Mean distance to the neighbours (local).
  double spacing = 0;
  /// False where the neighbours lie along a line, so that the normal is one of many.
  bool certain = false;
};

/// Paper 2, equations 1 and 2, with Levin's weight exp(-d^2 / H^2); the point itself has weight 1.
Tangent tangent_of(const Neighbours& neighbours);

/// Star of a point among its neighbours, as positions in the list of neighbours.
struct Star {
  std::array<std::uint32_t, LocalStars::kLongestStar> corners;
  std::size_t count = 0;
  bool closed = false;
  /// No point farther away than the neighbours can change it.
  bool certain = false;
};

/// Room that stars are made in, kept between calls.
struct StarScratch {
  std::vector<double> x, y, tie;
};

void star_of(std::size_t v, const Neighbours& neighbours, const Tangent& tangent, StarKind kind, StarScratch& scratch,
             Star& star);

}  // namespace surfaced::front
