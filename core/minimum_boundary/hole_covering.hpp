// SPDX-License-Identifier: GPL-3.0-or-later
// Hole covering (§5.4): sets of facets, "lids", that close the holes in the hull of BC.
#pragma once

#include <optional>
#include <vector>

#include "minimum_boundary/artifacts.hpp"
#include "minimum_boundary/ball_ratio.hpp"
#include "minimum_boundary/boundary_complex.hpp"

namespace surfaced::boundary {

/// A boundary complex with its holes covered, and how.
struct Covered {
  FacetSet facets;
  std::size_t lids = 0;
  /// Artifacts that were looked at, and those with hull holes (lids=paper).
  std::size_t artifacts = 0;
  std::size_t hull_holes = 0;
  /// Ball ratio below which facets became lids (lids=ball), or that told which cells may be seeds (lids=mincut).
  double delta = 0;
  /// lids=mincut: how large seeds are.
  double seed_factor = 0;
};

/// What the outside leaves of the points when it floods everything that is not walled off, before inflating.
struct FloodScore {
  /// Points outside or pinched: many where the outside leaks in.
  std::size_t lost = 0;
  std::size_t interior = 0;
  std::size_t sum() const { return lost + interior; }
};
FloodScore flood_score(const DelaunayComplex& complex, const FacetSet& walls, unsigned threads);

/// The paper's way: for every artifact with a hull hole all facets of the triangulation between its vertices, pruned
/// until no edge has a single facet; of these the shortest that keep the outside out. Where the outside takes more than
/// a tenth of the points all the same, it has entered the slivers at the rim, of which the text says nothing; then the
/// shortest facets between the vertices of all artifacts and lost points.
/// @cost  O(cells log cells).
Covered cover_by_artifacts(const Walls& walls, const Criterion& criterion);

/// BC with all facets whose ball ratio is below delta.
Covered cover_at(const DelaunayComplex& complex, const FacetSet& boundary, const BallRatio& ratio, double delta);

struct Rung {
  double delta;
  FloodScore score;
};
/// Scores of a fixed ladder of ball ratios, ascending.
/// @return  cancelled.
Result<std::vector<Rung>> climb_ladder(const DelaunayComplex& complex, const FacetSet& boundary, const BallRatio& ratio,
                                       Context& context);

/// `cover_at` delta. Without delta, at the rung of the ladder that leaves the fewest points outside, inside or
/// pinched.
/// @return  cancelled.
Result<Covered> cover_by_balls(const DelaunayComplex& complex, const FacetSet& boundary, std::optional<double> delta,
                               Context& context);

}  // namespace surfaced::boundary
