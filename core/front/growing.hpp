// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/cloud.hpp"
#include "front/closing.hpp"
#include "front/local_stars.hpp"
#include "front/seeding.hpp"
#include "front/statistics.hpp"

namespace surfaced::front {

/// Where papers 2 and 3 differ on the way from points to a mesh.
struct GrowthParameters {
  /// What messages call the method.
  std::string_view method;
  StarParameters stars;
  SewingParameters sewing;
  /// Whether to begin with the triangles on which three stars agree, or with seeds alone.
  bool begin_with_consensus = true;
  /// Whether the longest edge and the capsule hold for those triangles too; else only for what comes later.
  bool limit_consensus = true;
  /// Sets the first face or faces at a vertex without any; false where it cannot.
  std::function<bool(Fans&, Places&, std::uint32_t)> plant = seed_triangle;
  bool fill_small_holes = true;
  /// Last step on the finished surface; none if empty.
  std::function<Status(Fans&, Places&, Context&)> improve = {};
};

/// A surface grown over the points of a cloud.
struct Surface {
  /// Vertex v is point v of the cloud; unused points are in no triangle.
  TriangleMesh mesh;
  std::vector<std::string> warnings;
  Statistics statistics;
};

/// Stars, consensus, front, small holes, leftover points, `improve`, orientation: the whole way.
/// @return  an oriented edge- and vertex-manifold mesh whose vertices are points of the cloud, closed parts facing
///          outwards; too_few_points (3 needed), collinear, cancelled, out_of_memory.
/// @cost    O(V) for points on surfaces.
Result<Surface> grow_surface(const PointCloud& cloud, const GrowthParameters& parameters, Context& context);

}  // namespace surfaced::front
