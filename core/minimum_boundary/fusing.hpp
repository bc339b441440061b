// SPDX-License-Identifier: GPL-3.0-or-later
// Fusing: takes from another labelling the regions in which it is better.
#pragma once

#include <limits>

#include "minimum_boundary/candidates.hpp"
#include "minimum_boundary/connectivity.hpp"

namespace surfaced::boundary {

/// Handles of the surface, and how many most candidates have.
struct Handles {
  std::int64_t now = 0;
  std::int64_t usual = 0;
};

struct Fused {
  std::size_t regions = 0;
  std::size_t taken = 0;
  /// Least |score| of a region whose other labels would change χ by handles, not by components: how near the choice
  /// between two topologies was. Infinite if there was none to make.
  double margin = std::numeric_limits<double>::infinity();
};

/// The cells in which two manifold labellings differ fall into regions that share no vertex, so that any choice
/// of regions is manifold again: the star of every vertex comes wholly from one of the two. Takes a region if
/// ΔΣλ / λ(region) + 6 Δint + 3 Δ|handles - usual| < 0 and it adds no component; with `one_component` each component
/// that it removes counts as much as in the choice of the candidate. Keeps `handles.now`.
/// @cost  O(cells) and a search near each region that is better.
Fused fuse(Labelling& labels, const Labelling& other, const Criterion& criterion, bool one_component, Handles& handles,
           SurfaceSearch& search);

}  // namespace surfaced::boundary
