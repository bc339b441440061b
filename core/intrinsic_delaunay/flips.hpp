// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "front/front.hpp"
#include "intrinsic_delaunay/intrinsic_delaunay.hpp"

namespace surfaced::idt {

/// The two faces at the edge ab: (a, b, left) and (b, a, right).
struct Diamond {
  std::uint32_t a;
  std::uint32_t b;
  std::uint32_t left;
  std::uint32_t right;
};

/// Whether the angles at left and right, in space, add up to more than π; compared by their cotangents, whose sum is
/// then negative.
bool angles_exceed_pi(const front::Places& places, const Diamond& diamond);
bool angles_exceed_pi(const Point3& a, const Point3& b, const Point3& left, const Point3& right);

/// Paper 3, table 1, step 6, with propagation: flips every edge with α1 + α2 > π, then looks at the four around it
/// again (Lawson), as long as the surface stays valid: the new edge is not there yet, the four points are convex in
/// their mean plane, the new normals are within 60° of its normal, and the faces are legal for the front. In a plane
/// the flips end by themselves; in space each has to make the smallest angle larger, and an edge is
/// flipped at most 10 times. Four points that are not in a plane may have two diagonals with α1 + α2 <= π: of those the
/// one with the larger least r/L is taken, if no edge around fails by that.
/// @return  cancelled.
/// @cost    O(V) to find the edges, in parallel, and O(1) a flip.
Result<FlipCounts> flip_edges(front::Fans& fans, front::Places& places, Context& context);

}  // namespace surfaced::idt
