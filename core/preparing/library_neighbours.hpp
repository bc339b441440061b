// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: neighbourhoods as CGAL's point set processing takes them, so that each can be looked at before
// anything is fitted to it.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "preparing/preparing.hpp"

namespace surfaced::preparing {

std::vector<Point3> local_points(const PointCloud& cloud, const LocalFrame& frame);

/// Calls visit(v, near) for every point v: `near` are the point and its k nearest others, nearest first. Ends early
/// once the caller wants to stop.
/// @param until  the share of the stage's progress that it takes.
void each_neighbourhood(std::span<const Point3> points, std::size_t k, double until, Context& context,
                        const std::function<void(std::size_t v, std::span<const Point3> near)>& visit);

}  // namespace surfaced::preparing
