// SPDX-License-Identifier: GPL-3.0-or-later
#include "preparing/library_neighbours.hpp"

#include <CGAL/Point_set_processing_3/internal/Neighbor_query.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/property_map.h>

#include <iterator>

namespace surfaced::preparing {

std::vector<Point3> local_points(const PointCloud& cloud, const LocalFrame& frame) {
  std::vector<Point3> points;
  points.reserve(cloud.size());
  for (const Point3& p : cloud.positions) points.push_back(frame.to_local(p));
  return points;
}

void each_neighbourhood(std::span<const Point3> points, std::size_t k, double until, Context& context,
                        const std::function<void(std::size_t v, std::span<const Point3> near)>& visit) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using LibraryPoints = std::vector<Kernel::Point_3>;
  using Map = CGAL::Identity_property_map<Kernel::Point_3>;
  LibraryPoints places;
  places.reserve(points.size());
  for (const Point3& p : points) places.emplace_back(p[0], p[1], p[2]);
  const CGAL::Point_set_processing_3::internal::Neighbor_query<Kernel, LibraryPoints&, Map> query(places, Map());
  LibraryPoints found;
  std::vector<Point3> near;
  for (std::size_t v = 0; v < points.size() && !context.cancelled(); ++v) {
    found.clear();
    query.get_points(places[v], static_cast<unsigned>(k), 0, std::back_inserter(found));
    near.clear();
    for (const Kernel::Point_3& p : found) near.push_back({p.x(), p.y(), p.z()});
    visit(v, near);
    context.report(until * static_cast<double>(v + 1) / static_cast<double>(points.size()));
  }
}

}  // namespace surfaced::preparing
