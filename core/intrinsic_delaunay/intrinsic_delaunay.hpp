// Method `intrinsic-delaunay` (iDT, Gong et al. 2014): a front whose candidates lie in a capsule about the edge, then
// flips towards the intrinsic Delaunay triangulation, whose triangles have bounded quality on dense samples.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/base.hpp"
#include "cloud/cloud.hpp"
#include "front/statistics.hpp"
#include "intrinsic_delaunay/certificate.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

struct IntrinsicDelaunayParameters {
  enum class FillHoles : std::uint8_t { small, none };

  /// Sampling radius ε in the unit of the input: candidates lie within 2ε of the edge. None: at every point the
  /// distance to its 6th nearest neighbour.
  std::optional<double> epsilon = std::nullopt;
  /// Longest edge, as a multiple of the distance to the 6th nearest neighbour; none: 3, but triangles on which the
  /// local triangulations of their three vertices agree may be larger.
  std::optional<double> max_edge = std::nullopt;
  FillHoles fill_holes = FillHoles::small;
};

struct IntrinsicDelaunayStatistics {
  front::Statistics front;
  std::size_t flips = 0;
  /// Edges left with opposite angles of more than π together: flipping them would fold or cross the surface.
  std::size_t not_flippable = 0;
  /// Faces taken away from rims because their circumcircles are larger than the longest edge allowed.
  std::size_t peeled_faces = 0;
};

struct IntrinsicDelaunayResult {
  /// Vertex v is point v of the cloud; unused points are in no triangle.
  TriangleMesh mesh;
  std::vector<std::string> warnings;
  IntrinsicDelaunayStatistics statistics;
};

/// @return  an oriented edge- and vertex-manifold mesh whose vertices are points of the cloud, closed parts facing
///          outwards; too_few_points (3 needed), collinear, cancelled, out_of_memory.
/// @cost    O(V) for points on surfaces.
Result<IntrinsicDelaunayResult> intrinsic_delaunay(const PointCloud& cloud,
                                                   const IntrinsicDelaunayParameters& parameters, Context& context);

}  // namespace surfaced
