// SPDX-License-Identifier: GPL-3.0-or-later
// Methods taken from CGAL: for comparison, and for clouds that the papers' methods do not suit.
#pragma once

#include <optional>

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

/// Scale-space meshing (Digne et al. 2011): smooths the points step by step, meshes the smooth ones, and carries the
/// triangles back to the points they came from.
struct ScaleSpaceParameters {
  /// Steps of smoothing. 0 is the advancing front alone.
  std::size_t iterations = 4;
  /// Points that the neighbourhood of a step has on average, at least 3.
  std::size_t neighbours = 12;
};

/// @return  as advancing_front.
/// @cost    per step two searches of all points within a ball that holds `neighbours` of them on average, so much more
///          where points crowd; then an advancing front.
Result<TriangleMesh> scale_space(const PointCloud& cloud, const ScaleSpaceParameters& parameters, Context& context);

/// Poisson reconstruction (Kazhdan et al. 2006; on a Delaunay triangulation as CGAL has it). All lengths in spacings.
struct PoissonParameters {
  /// Triangles further than this from all points are dropped; none keeps the whole closed surface.
  std::optional<double> trim = 6;
  /// Largest radius of the balls around the triangles.
  double facet_radius = 2;
  /// Largest distance of a triangle's circumcentre from the surface.
  double facet_distance = 0.25;
  /// Nearest neighbours that normals are estimated from, where the cloud has none; at most a 24th of the points, but 9.
  std::size_t normal_neighbours = 18;
};

struct PoissonResult {
  static constexpr double kLeftOut = 2;
  TriangleMesh mesh;
  /// Points further from all vertices than `facet_radius` and this many spacings more: outliers, and parts of which no
  /// surface was found.
  std::size_t points_left_out = 0;
};

/// @return  a mesh with vertices of its own, which carry the normals and colours of the nearest point; it faces
///          outwards. too_few_points (4 needed, 10 without normals), coplanar, cancelled, out_of_memory, method_failed.
/// @cost    a refined Delaunay triangulation of some 6 vertices a point, a sparse linear system on it, and a second
///          Delaunay triangulation of the surface.
Result<PoissonResult> poisson(const PointCloud& cloud, const PoissonParameters& parameters, Context& context);

/// Alpha wrapping (Portaneri et al. 2022): shrinks a box around the points until it holds them. All lengths in
/// spacings.
struct AlphaWrapParameters {
  static constexpr double kAlphaPerOffset = 6;
  /// Openings smaller than this stay closed; triangles have about this size. None: the least of 12, 6 and 3 whose wrap
  /// does not leak, which a wrap of less than half the volume of the one before is taken to do.
  std::optional<double> alpha;
  /// Distance from the wrap to the points; none: alpha / kAlphaPerOffset.
  std::optional<double> offset;
};

struct AlphaWrapResult {
  TriangleMesh mesh;
  /// As used, in spacings.
  double alpha = 0;
  double offset = 0;
};

/// @return  a closed mesh with vertices of its own, which carry the normals and colours of the nearest point; it faces
///          outwards. too_few_points (3 needed), cancelled, out_of_memory, method_failed.
/// @cost    a Delaunay triangulation of the wrap's vertices, some queries of the points for each.
Result<AlphaWrapResult> alpha_wrap(const PointCloud& cloud, const AlphaWrapParameters& parameters, Context& context);

}  // namespace surfaced
