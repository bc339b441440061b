// Lids by a guarded watershed over the balls of the cells: which cells lie on the same side of the surface.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "delaunay/delaunay.hpp"
#include "minimum_boundary/ball_ratio.hpp"
#include "minimum_boundary/boundary_complex.hpp"

namespace surfaced::boundary {

/// Cells merged across facets of falling ball ratio; `cluster[c]` is the least cell of its cluster. All
/// infinite cells are in one.
struct Clusters {
  std::vector<std::uint32_t> cluster;
  std::uint32_t outside = 0;
};

/// The clusters as they are once all facets above each level have been seen.
struct Watershed {
  static constexpr std::array<float, 3> kLevels{1.7F, 1.4F, 1.0F};
  std::array<Clusters, 3> at_level;
  /// Pairs of clusters that the evidence keeps apart.
  std::size_t guarded = 0;
};

/// A facet of BC_0 whose balls overlap little is evidence that the surface passes between its two cells:
/// above this ratio it is none.
inline constexpr float kEvidenceBelow = 1.1F;
inline constexpr float kEvidenceUnit = 1.11F;

/// Merges the cells across all facets that are not of BC_0, highest ball ratio first, except where enough of
/// the BC_0 facets on the smaller cluster's border say that the other cluster lies on the other side.
/// @return  cancelled.
Result<Watershed> guarded_watershed(const DelaunayComplex& complex, const BoundaryComplex& boundary,
                                    const BallRatio& ratio, Context& context);

}  // namespace surfaced::boundary
