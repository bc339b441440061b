// SPDX-License-Identifier: GPL-3.0-or-later
// Jets: projection of every point onto the quadric that fits its neighbours, by CGAL's jet_smooth_point_set. Bilateral:
// H. Huang, S. Wu, M. Gong, D. Cohen-Or, U. Ascher, H. Zhang, "Edge-aware point set resampling", ACM Transactions on
// Graphics 32 (2013), section 4, by CGAL's bilateral_smooth_point_set.
#define CGAL_EIGEN3_ENABLED
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/bilateral_smooth_point_set.h>
#include <CGAL/jet_smooth_point_set.h>

#include <algorithm>

#include "base/vectors.hpp"
#include "preparing/stage.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using PointVector = std::pair<Kernel::Point_3, Kernel::Vector_3>;

std::vector<PointVector> library_points(const PointCloud& cloud, const LocalFrame& frame) {
  std::vector<PointVector> points;
  points.reserve(cloud.size());
  for (std::size_t v = 0; v < cloud.size(); ++v) {
    const Point3 p = frame.to_local(cloud.positions[v]);
    Kernel::Vector_3 normal = CGAL::NULL_VECTOR;
    if (!cloud.normals.empty()) {
      const Normal3& n = cloud.normals[v];
      const Point3 unit =
          direction_of({static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])})
              .value_or(Point3{0, 0, 1});
      normal = {unit[0], unit[1], unit[2]};
    }
    points.emplace_back(Kernel::Point_3(p[0], p[1], p[2]), normal);
  }
  return points;
}

void smooth(std::vector<PointVector>& points, Smoothing way, unsigned neighbours, Context& context) {
  // A lambda, not a std::function: CGAL 5.5.1 would keep a reference to a copy of that which has ended.
  const auto parameters = CGAL::parameters::point_map(CGAL::First_of_pair_property_map<PointVector>())
                              .normal_map(CGAL::Second_of_pair_property_map<PointVector>())
                              .callback([&context](double done) {
                                context.report(done);
                                return !context.cancelled();
                              });
  if (way == Smoothing::jet) {
    CGAL::jet_smooth_point_set<CGAL::Sequential_tag>(points, neighbours, parameters);
  } else {
    CGAL::bilateral_smooth_point_set<CGAL::Sequential_tag>(points, neighbours, parameters);
  }
}

}  // namespace

Result<PointCloud> smoothed(const PointCloud& cloud, Smoothing way, std::size_t neighbours, Context& context) {
  // A jet of degree 2 has 6 coefficients.
  constexpr std::size_t kFewest = 7;
  return preparing::guarded<PointCloud>("smoothing", context, [&]() -> Result<PointCloud> {
    if (cloud.size() < kFewest) return cloud;
    const std::size_t k = std::min(neighbours, cloud.size() - 1);
    std::optional<PointCloud> with;
    if (way == Smoothing::bilateral && cloud.normals.empty()) {
      Result<PointCloud> estimated = with_normals(cloud, NormalFit::plane, k, context);
      if (!estimated) return estimated;
      with = std::move(*estimated);
    }
    const LocalFrame frame(cloud.positions);
    std::vector<PointVector> points = library_points(with ? *with : cloud, frame);
    smooth(points, way, static_cast<unsigned>(k), context);
    if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled during smoothing"};
    RawCloud raw;
    raw.warnings = cloud.warnings;
    raw.normals = cloud.normals;
    raw.colors = cloud.colors;
    for (std::size_t v = 0; v < points.size(); ++v) {
      const Kernel::Point_3& p = points[v].first;
      const Point3 moved = frame.to_input({p.x(), p.y(), p.z()});
      // Neighbours in a line fit no quadric.
      raw.positions.push_back(is_finite(moved) ? moved : cloud.positions[v]);
    }
    return make_cloud(std::move(raw), context.threads());
  });
}

}  // namespace surfaced
