// Private to the room: the stages before and after a method that any method takes.
#pragma once

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// Schemas of their parameters.
Json preparing_properties();

/// A cloud as a method gets it.
struct Prepared {
  PointCloud cloud;
  /// For the report: name, points in and out of every stage that ran.
  Json stages = Json::array();
};

/// Runs the stages that the parameters ask for, in the order outliers, sample.
/// @return  cancelled, out_of_memory, method_failed (nothing is left).
Result<Prepared> prepare(PointCloud cloud, const Json& parameters, Context& context);

/// Drops the parts of a mesh that have fewer than `fraction` times the triangles of the largest; says so in the
/// warnings.
void drop_small_parts(Reconstruction& result, double fraction);

}  // namespace surfaced
