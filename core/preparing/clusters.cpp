// SPDX-License-Identifier: GPL-3.0-or-later
// Hierarchical: M. Pauly, M. Gross, L. Kobbelt, "Efficient simplification of point-sampled surfaces", IEEE
// Visualization 2002, by CGAL's hierarchy_simplify_point_set. WLOP: H. Huang, D. Li, H. Zhang, U. Ascher, D. Cohen-Or,
// "Consolidation of unorganized point clouds for surface reconstruction", ACM Transactions on Graphics 28 (2009), by
// CGAL's wlop_simplify_and_regularize_point_set.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/hierarchy_simplify_point_set.h>
#include <CGAL/wlop_simplify_and_regularize_point_set.h>

#include <algorithm>
#include <cmath>

#include "preparing/stage.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Numbered = std::pair<Kernel::Point_3, std::size_t>;

Kernel::Point_3 library_point(const Point3& local) { return {local[0], local[1], local[2]}; }

/// A lambda, not a std::function: CGAL 5.5.1 would keep a reference to a copy of that which has ended.
auto callback(Context& context) {
  return [&context](double done) {
    context.report(done);
    return !context.cancelled();
  };
}

}  // namespace

Result<PointCloud> clustered(const PointCloud& cloud, double share, Context& context) {
  return preparing::guarded<PointCloud>("sampling", context, [&]() -> Result<PointCloud> {
    const LocalFrame frame(cloud.positions);
    std::vector<Numbered> points;
    for (std::size_t v = 0; v < cloud.size(); ++v) {
      points.emplace_back(library_point(frame.to_local(cloud.positions[v])), v);
    }
    const auto size = static_cast<unsigned>(std::clamp(std::round(1 / share), 1.0, 1e9));
    const auto dropped = CGAL::hierarchy_simplify_point_set(
        points, CGAL::parameters::point_map(CGAL::First_of_pair_property_map<Numbered>())
                    .size(size)
                    .callback(callback(context)));
    if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled during sampling"};
    std::vector<std::size_t> kept;
    for (auto each = points.begin(); each != dropped; ++each) kept.push_back(each->second);
    std::ranges::sort(kept);
    return preparing::chosen(cloud, kept, context.threads());
  });
}

Result<PointCloud> consolidated(const PointCloud& cloud, double share, Context& context) {
  // In spacings of the sample: more draws the points together where the surface bends.
  constexpr double kReach = 2;
  return preparing::guarded<PointCloud>("sampling", context, [&]() -> Result<PointCloud> {
    const double spacing = spacing_of(cloud.positions, context.threads());
    if (!(spacing > 0) || share * static_cast<double>(cloud.size()) < 1) return cloud;
    const LocalFrame frame(cloud.positions);
    std::vector<Kernel::Point_3> points;
    for (const Point3& p : cloud.positions) points.push_back(library_point(frame.to_local(p)));
    std::vector<Kernel::Point_3> sample;
    CGAL::wlop_simplify_and_regularize_point_set<CGAL::Sequential_tag>(
        points, std::back_inserter(sample),
        CGAL::parameters::select_percentage(100 * share)
            .neighbor_radius(kReach / std::sqrt(share) * frame.to_local(spacing))
            .callback(callback(context)));
    if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled during sampling"};
    RawCloud raw;
    raw.warnings = cloud.warnings;
    for (const Kernel::Point_3& p : sample) raw.positions.push_back(frame.to_input({p.x(), p.y(), p.z()}));
    for (const VertexIndex v : nearest_points(cloud.positions, raw.positions, context.threads()).index) {
      if (!cloud.normals.empty()) raw.normals.push_back(cloud.normals[v]);
      if (!cloud.colors.empty()) raw.colors.push_back(cloud.colors[v]);
    }
    return make_cloud(std::move(raw), context.threads());
  });
}

}  // namespace surfaced
