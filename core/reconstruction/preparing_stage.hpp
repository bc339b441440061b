// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: the stages before and after a method that any method takes.
#pragma once

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// Schemas of their parameters.
Json preparing_properties();

/// Whether any stage before the method is asked for.
bool asks_for_preparing(const Json& parameters);
/// Whether one of them moves points, so that the method's vertices are not the input's.
bool moves_points(const Json& parameters);

/// A cloud as a method gets it.
struct Prepared {
  PointCloud cloud;
  /// For the report: name, points in and out of every stage that ran.
  Json stages = Json::array();
};

/// Runs the stages that the parameters ask for, in the order fuse, outliers, sample, smooth, normals.
/// @return  cancelled, out_of_memory, method_failed (nothing is left).
Result<Prepared> prepare(PointCloud cloud, const Json& parameters, Context& context);

/// Drops the parts of a mesh that have fewer than `fraction` times the triangles of the largest; says so in the
/// warnings.
void drop_small_parts(Reconstruction& result, double fraction);

}  // namespace surfaced
