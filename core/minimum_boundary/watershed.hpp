// SPDX-License-Identifier: GPL-3.0-or-later
// Lids by a guarded watershed over the balls of the cells: which cells lie on the same side of the surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "delaunay/delaunay.hpp"
#include "minimum_boundary/boundary_complex.hpp"

namespace surfaced::boundary {

/// Cells merged across facets of falling ball ratio; `cluster[c]` is the least cell of its cluster. All
/// infinite cells are in one.
struct Clusters {
  std::vector<std::uint32_t> cluster;
  std::uint32_t outside = 0;
};

/// Per cell 1 unless it is in the cluster of the infinite cells.
std::vector<std::uint8_t> inside_of(const Clusters& clusters);

/// Levels of the ball ratio at which the clusters are looked at.
inline constexpr float kCautiousLevel = 1.7F;
inline constexpr float kColouringLevel = 1.4F;
inline constexpr float kThoroughLevel = 1.0F;

/// Ball ratios of the finite facets and those between infinite cells, in steps of 2/65535. They do not depend on
/// BC_0.
struct FacetRatings {
  /// At the side of the lesser cell; 0 at the other side.
  std::vector<std::uint16_t> steps;
  /// Bit i: the ratio at side i is so low that the facet is evidence if BC_0 has it.
  std::vector<std::uint8_t> low;
  struct Passage {
    SideIndex side;
    CellIndex beyond;
  };
  /// Facets at or above the thorough level, descending by ratio, ties by side.
  std::vector<Passage> passages;

  static constexpr float kStepsPerUnit = 65535.0F / 2;
  static constexpr std::uint32_t step_of(float ratio) { return static_cast<std::uint32_t>(ratio * kStepsPerUnit); }
};

/// @cost  O(cells); about 0.25 kB per point while it runs.
FacetRatings rate_facets(const DelaunayComplex& complex, unsigned threads);

/// Facet ratings with the evidence of BC_0.
struct RatedFacets {
  /// Ratio of a facet at the side of its lesser cell; of BC_0 facets at both sides.
  std::vector<std::uint16_t> steps;
  /// Bit i: side i of the cell is a BC_0 facet whose balls overlap little, which is evidence that the surface
  /// passes between its two cells.
  std::vector<std::uint8_t> evidence;
  std::vector<FacetRatings::Passage> passages;

  /// How much a facet with evidence says: the less its balls overlap, the more.
  std::int64_t weight(SideIndex s) const { return std::int64_t{FacetRatings::step_of(kWeightlessRatio)} - steps[s]; }

  /// A facet of BC_0 at or above the first is no evidence; at the second its weight would be 0.
  static constexpr float kEvidenceBelow = 1.1F;
  static constexpr float kWeightlessRatio = 1.11F;
};

RatedFacets with_evidence(const DelaunayComplex& complex, FacetRatings ratings, const FacetSet& boundary,
                          unsigned threads);

/// Merges the cells across all facets that are not of BC_0, highest ball ratio first, except where enough of
/// the BC_0 facets on the smaller cluster's border say that the other cluster lies on the other side.
/// @param levels  descending, the last not below the thorough level.
/// @return  for each level the clusters as they are once all facets above it have been seen; cancelled.
/// @cost    O(cells α(cells)) and the evidence of the smaller cluster at every meeting of two.
Result<std::vector<Clusters>> guarded_watershed(const DelaunayComplex& complex, const FacetSet& boundary,
                                                const RatedFacets& rated, std::span<const float> levels,
                                                Context& context);

}  // namespace surfaced::boundary
