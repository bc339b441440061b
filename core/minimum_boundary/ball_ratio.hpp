// SPDX-License-Identifier: GPL-3.0-or-later
// How deeply the circumscribed balls of two neighbouring cells run into each other.
#pragma once

#include <vector>

#include "delaunay/delaunay.hpp"

namespace surfaced::boundary {

/// (r0 + r1 - d) / min(r0, r1) for balls of radii r0, r1 at distance d: 2 where one centre lies in the other's
/// small ball, 0 where the balls only touch. High inside a volume, low across a well-sampled surface
/// (BallMerge, Parakkat et al. 2024). It ranks facets; no rounding of it can harm the surface's validity.
class BallRatio {
 public:
  explicit BallRatio(const DelaunayComplex& complex, unsigned threads);

  /// 0..2; for a hull facet the outer ball is the half-space. Facets of infinite cells with each other: 2.
  float of(SideIndex s) const;

  /// Circumradius of a finite cell; infinite where it is too flat to compute.
  float radius(CellIndex c) const { return balls_[c].radius; }

 private:
  struct Ball {
    float x, y, z, radius;
  };
  float against_hull(SideIndex infinite_side) const;

  const DelaunayComplex& complex_;
  std::vector<Ball> balls_;
};

}  // namespace surfaced::boundary
