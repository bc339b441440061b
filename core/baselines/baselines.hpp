// Methods taken from CGAL: for comparison, and for clouds that the papers' methods do not suit.
#pragma once

#include "base/base.hpp"
#include "cloud/cloud.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

/// CGAL's advancing front (Cohen-Steiner and Da 2004): grows a surface over the facets of the 3-D
/// Delaunay triangulation, most plausible facet first.
struct AdvancingFrontParameters {
  /// Candidates outside the wedge are dropped if their radius is larger than this times the radius of
  /// the facet they continue; smaller leaves more openings. At least 1, dimensionless.
  double radius_ratio_bound = 5;
  /// Half the angle (radians, 0..π) of the wedge in which only the radius counts.
  double beta = 0.52;
};

/// @return  a mesh whose vertex v is point v of the cloud (vertices of no triangle included), oriented,
///          closed parts facing outwards; openings stay where the sampling leaves them.
///          too_few_points (3 needed), collinear, cancelled, method_failed.
/// @cost    one Delaunay triangulation and about as much again, 1.7 kB per point.
Result<TriangleMesh> advancing_front(const PointCloud& cloud, const AdvancingFrontParameters& parameters,
                                     Context& context);

}  // namespace surfaced
