// Source: W. Gong, Y.-J. Liu, K. Tang, T. Wu, "Approximate Delaunay mesh reconstruction and quality estimation from
// point samples", Journal of Computational and Applied Mathematics 274 (2015), sections 2 and 3.1.
#include "intrinsic_delaunay/intrinsic_delaunay.hpp"

#include <utility>

#include "front/front.hpp"

namespace surfaced {
namespace {

using Parameters = IntrinsicDelaunayParameters;

}  // namespace

Result<IntrinsicDelaunayResult> intrinsic_delaunay(const PointCloud& cloud, const Parameters& parameters,
                                                   Context& context) {
  front::GrowthParameters growth{.method = "intrinsic-delaunay",
                                 .stars = {.kind = front::StarKind::unfolded},
                                 .sewing = {.max_edge = parameters.max_edge},
                                 .fill_small_holes = parameters.fill_holes == Parameters::FillHoles::small};
  Result<front::Surface> surface = front::grow_surface(cloud, growth, context);
  if (!surface) return std::move(surface).error();
  return IntrinsicDelaunayResult{.mesh = std::move(surface->mesh),
                                 .warnings = std::move(surface->warnings),
                                 .statistics = {.front = surface->statistics}};
}

}  // namespace surfaced
