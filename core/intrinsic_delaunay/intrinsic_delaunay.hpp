// SPDX-License-Identifier: GPL-3.0-or-later
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
  /// Flips between two diagonals that are both Delaunay, towards the larger least r/L.
  std::size_t exchanges = 0;
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

namespace idt {

struct FlipCounts {
  std::size_t flips = 0;
  /// Flips between two diagonals that both satisfy it.
  std::size_t exchanges = 0;
  /// Edges that still have α1 + α2 > π: flipping them would fold or cross the surface.
  std::size_t not_flippable = 0;
};

/// Step 6 of table 1 on a finished mesh: flips edges with α1 + α2 > π, and takes the better of two diagonals that both
/// are Delaunay, as intrinsic_delaunay does at its end. The length of edges is not limited. The triangles are sorted if
/// any changes. Requires an oriented edge-manifold mesh.
/// @return  cancelled, out_of_memory.
/// @cost    O(V + F); about 100 bytes per vertex.
Result<FlipCounts> flip_edges(TriangleMesh& mesh, Context& context);

}  // namespace idt
}  // namespace surfaced
