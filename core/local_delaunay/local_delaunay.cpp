// SPDX-License-Identifier: GPL-3.0-or-later
// Source: H. H. Bíscaro, "Efficient reconstruction from scattered points", WSCG 2010.
#include "local_delaunay/local_delaunay.hpp"

#include <algorithm>
#include <utility>

#include "front/front.hpp"
#include "local_delaunay/seeding.hpp"

namespace surfaced {
namespace {

using Parameters = LocalDelaunayParameters;

front::StarParameters star_parameters(const Parameters& p) {
  front::StarParameters s;
  s.neighbours = p.neighbours;
  if (p.star == Parameters::Star::unfolded) s.kind = front::StarKind::unfolded;
  if (p.star == Parameters::Star::projected) s.kind = front::StarKind::projected;
  return s;
}

front::SewingParameters sewing_parameters(const Parameters& p) {
  front::SewingParameters s;
  s.angle = p.angle == Parameters::Angle::projected ? front::Angle::projected : front::Angle::spatial;
  s.reach = std::max(s.reach, 2 * p.neighbours);
  s.max_edge = p.max_edge;
  return s;
}

}  // namespace

/// Algorithm 1; its steps 4 to 13, the front, are front::grow_surface's.
Result<LocalDelaunayResult> local_delaunay(const PointCloud& cloud, const LocalDelaunayParameters& parameters,
                                           Context& context) {
  front::GrowthParameters growth{.method = "local-delaunay",
                                 .stars = star_parameters(parameters),
                                 .sewing = sewing_parameters(parameters),
                                 .fill_small_holes = parameters.fill_holes == Parameters::FillHoles::small};
  if (parameters.seed == Parameters::Seed::paper) {
    growth.begin_with_consensus = false;
    growth.plant = [&](front::Fans& fans, front::Places& places, std::uint32_t v) {
      return ldt::seed_local_triangulation(fans, places, v, parameters.neighbours);
    };
  }
  Result<front::Surface> surface = front::grow_surface(cloud, growth, context);
  if (!surface) return std::move(surface).error();
  return LocalDelaunayResult{
      .mesh = std::move(surface->mesh), .warnings = std::move(surface->warnings), .statistics = surface->statistics};
}

}  // namespace surfaced
