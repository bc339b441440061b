// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: neighbourhoods as CGAL's point set processing takes them, so that each can be looked at before
// anything is fitted to it.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Point_set_processing_3/internal/Neighbor_query.h>
#include <CGAL/property_map.h>

#include <iterator>
#include <vector>

#include "preparing/preparing.hpp"

namespace surfaced::preparing {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using LibraryPoints = std::vector<Kernel::Point_3>;

inline LibraryPoints local_points(const PointCloud& cloud, const LocalFrame& frame) {
  LibraryPoints points;
  points.reserve(cloud.size());
  for (const Point3& p : cloud.positions) {
    const Point3 local = frame.to_local(p);
    points.emplace_back(local[0], local[1], local[2]);
  }
  return points;
}

/// Calls visit(v, near) for every point v: `near` are the point and its k nearest others, nearest first. Ends early
/// once the caller wants to stop.
/// @param until  the share of the stage's progress that it takes.
template <class Visit>
void each_neighbourhood(LibraryPoints& points, std::size_t k, double until, Context& context, Visit visit) {
  using Map = CGAL::Identity_property_map<Kernel::Point_3>;
  const CGAL::Point_set_processing_3::internal::Neighbor_query<Kernel, LibraryPoints&, Map> query(points, Map());
  LibraryPoints near;
  for (std::size_t v = 0; v < points.size() && !context.cancelled(); ++v) {
    near.clear();
    query.get_points(points[v], static_cast<unsigned>(k), 0, std::back_inserter(near));
    visit(v, near);
    context.report(until * static_cast<double>(v + 1) / static_cast<double>(points.size()));
  }
}

}  // namespace surfaced::preparing
