// SPDX-License-Identifier: GPL-3.0-or-later
// Jets: projection of every point onto the quadric that fits its neighbours, as in CGAL's jet_smooth_point_set, which
// takes any neighbourhood for one that fits. Bilateral:
// H. Huang, S. Wu, M. Gong, D. Cohen-Or, U. Ascher, H. Zhang, "Edge-aware point set resampling", ACM Transactions on
// Graphics 32 (2013), section 4, by CGAL's bilateral_smooth_point_set.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/bilateral_smooth_point_set.h>

#include <algorithm>

#include "base/vectors.hpp"
#include "fitting/fitting.hpp"
#include "preparing/library_neighbours.hpp"
#include "preparing/stage.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using PointVector = std::pair<Kernel::Point_3, Kernel::Vector_3>;

/// Neighbours that fit no quadric leave their point where it is.
std::vector<Point3> onto_jets(const std::vector<Point3>& points, std::size_t neighbours, Context& context) {
  std::vector<Point3> moved = points;
  preparing::each_neighbourhood(points, neighbours, 1, context, [&](std::size_t v, std::span<const Point3> near) {
    if (const auto jet = jet_of(near, JetForm::curvatures)) moved[v] = jet->origin;
  });
  return moved;
}

std::vector<PointVector> with_directions(const std::vector<Point3>& points, const PointCloud& cloud) {
  std::vector<PointVector> result;
  result.reserve(points.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Point3& p = points[v];
    const Normal3& n = cloud.normals[v];
    const Point3 unit = direction_of({static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])})
                            .value_or(Point3{0, 0, 1});
    result.emplace_back(Kernel::Point_3(p[0], p[1], p[2]), Kernel::Vector_3(unit[0], unit[1], unit[2]));
  }
  return result;
}

/// Whether any neighbourhood has an extent; the library asks the largest for one.
bool spread(const std::vector<Point3>& points, std::size_t neighbours, Context& context) {
  bool any = false;
  preparing::each_neighbourhood(points, neighbours, 0, context, [&](std::size_t, std::span<const Point3> near) {
    any = any || near.front() != near.back();
  });
  return any;
}

/// @param cloud  with normals.
std::vector<Point3> along_normals(std::vector<Point3> points, const PointCloud& cloud, std::size_t neighbours,
                                  Context& context) {
  if (!spread(points, neighbours, context)) return points;
  std::vector<PointVector> moved = with_directions(points, cloud);
  // A lambda, not a std::function: CGAL 5.5.1 would keep a reference to a copy of that which has ended.
  CGAL::bilateral_smooth_point_set<CGAL::Sequential_tag>(
      moved, static_cast<unsigned>(neighbours),
      CGAL::parameters::point_map(CGAL::First_of_pair_property_map<PointVector>())
          .normal_map(CGAL::Second_of_pair_property_map<PointVector>())
          .callback([&context](double done) {
            context.report(done);
            return !context.cancelled();
          }));
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Kernel::Point_3& p = moved[v].first;
    points[v] = {p.x(), p.y(), p.z()};
  }
  return points;
}

}  // namespace

Result<PointCloud> smoothed(const PointCloud& cloud, Smoothing way, std::size_t neighbours, Context& context) {
  // A jet of degree 2 has 6 coefficients.
  constexpr std::size_t kFewest = 7;
  return preparing::guarded<PointCloud>("smoothing", context, [&]() -> Result<PointCloud> {
    if (cloud.size() < kFewest) return cloud;
    const std::size_t k = std::min(neighbours, cloud.size() - 1);
    const LocalFrame frame(cloud.positions);
    const std::vector<Point3> before = preparing::local_points(cloud, frame);
    std::vector<Point3> points;
    if (way == Smoothing::jet) {
      points = onto_jets(before, k, context);
    } else {
      Result<PointCloud> with =
          cloud.normals.empty() ? with_normals(cloud, NormalFit::plane, k, context) : Result<PointCloud>(cloud);
      if (!with) return with;
      points = along_normals(before, *with, k, context);
    }
    if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled during smoothing"};
    RawCloud raw;
    raw.warnings = cloud.warnings;
    raw.normals = cloud.normals;
    raw.colors = cloud.colors;
    for (std::size_t v = 0; v < points.size(); ++v) {
      const Point3 moved = frame.to_input(points[v]);
      raw.positions.push_back(is_finite(moved) && points[v] != before[v] ? moved : cloud.positions[v]);
    }
    return make_cloud(std::move(raw), context.threads());
  });
}

}  // namespace surfaced
