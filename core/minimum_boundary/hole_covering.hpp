// Hole covering (§5.4): sets of facets, "lids", that close the holes in the hull of BC.
#pragma once

#include <optional>
#include <span>

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
  /// Ball ratio below which facets became lids (lids=ball).
  double delta = 0;
  /// Share of the points left outside or pinched before inflating: large where the outside leaks in.
  double leak = 0;
};

/// The paper's way: for every artifact with a hull hole all facets of the triangulation between its vertices,
/// pruned until no edge has a single facet.
Covered cover_by_artifacts(const Walls& walls);

/// All facets whose ball ratio is below delta. Without delta, the one of a fixed ladder that leaves the
/// fewest points outside, inside or pinched.
Covered cover_by_balls(const DelaunayComplex& complex, const FacetSet& boundary, std::optional<double> delta,
                       unsigned threads);

}  // namespace surfaced::boundary
