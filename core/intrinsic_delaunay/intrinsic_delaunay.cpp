// SPDX-License-Identifier: GPL-3.0-or-later
// Source: W. Gong, Y.-J. Liu, K. Tang, T. Wu, "Approximate Delaunay mesh reconstruction and quality estimation from
// point samples", Journal of Computational and Applied Mathematics 274 (2015), section 3.1 and table 1.
#include "intrinsic_delaunay/intrinsic_delaunay.hpp"

#include <utility>

#include "front/front.hpp"
#include "intrinsic_delaunay/flips.hpp"
#include "intrinsic_delaunay/rims.hpp"

namespace surfaced {
namespace {

using Parameters = IntrinsicDelaunayParameters;

/// "A proper edge length threshold", for which the paper has no value: three times the spacing keeps openings open and
/// closes what scans have closed. It binds the front and, at rims, circumcircles; triangles on which three stars agree
/// need no limit elsewhere.
constexpr double kLongestEdge = 3;

/// Step 5: v from cap(e), in front of e, with the largest angle in space.
front::SewingParameters candidates_of(const Parameters& p) {
  return {.angle = front::Angle::spatial,
          .capsule = front::Capsule{.epsilon = p.epsilon},
          .max_edge = p.max_edge.value_or(kLongestEdge)};
}

}  // namespace

Result<IntrinsicDelaunayResult> intrinsic_delaunay(const PointCloud& cloud, const Parameters& parameters,
                                                   Context& context) {
  IntrinsicDelaunayStatistics statistics;
  // Step 6: flip(e), once all triangles are there.
  const auto flip = [&](front::Fans& fans, front::Places& places, Context& c) -> Status {
    if (Status begun = c.begin("flips", 0.97); !begun) return begun;
    const Result<idt::FlipCounts> counts = idt::flip_edges(fans, places, c);
    if (!counts) return counts.error();
    statistics.flips = counts->flips;
    statistics.exchanges = counts->exchanges;
    statistics.not_flippable = counts->not_flippable;
    statistics.peeled_faces = idt::peel_rims(fans, places);
    return Done{};
  };
  // Step 1: seed triangles with an empty ball; first those with an empty circle in all three unfolded neighbourhoods.
  // Steps 2 to 5 and 7: the front.
  const front::GrowthParameters growth{
      .method = "intrinsic-delaunay",
      .stars = {.kind = front::StarKind::unfolded},
      .sewing = candidates_of(parameters),
      .limit_consensus = parameters.epsilon.has_value() || parameters.max_edge.has_value(),
      .plant = front::seed_triangle,
      .fill_small_holes = parameters.fill_holes == Parameters::FillHoles::small,
      .improve = flip};
  Result<front::Surface> surface = front::grow_surface(cloud, growth, context);
  if (!surface) return std::move(surface).error();
  statistics.front = surface->statistics;
  return IntrinsicDelaunayResult{
      .mesh = std::move(surface->mesh), .warnings = std::move(surface->warnings), .statistics = statistics};
}

}  // namespace surfaced
