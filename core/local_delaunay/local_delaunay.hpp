// SPDX-License-Identifier: GPL-3.0-or-later
// Method `local-delaunay` (LDT, Bíscaro 2010): an advancing front over local Delaunay triangulations, without any
// structure in space. For very large clouds; keeps openings.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/base.hpp"
#include "cloud/cloud.hpp"
#include "front/statistics.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

struct LocalDelaunayParameters {
  /// How neighbours are laid out in the tangent plane: by their Voronoi cell in space, unfolded, or projected
  /// (the paper's).
  enum class Star : std::uint8_t { restricted, unfolded, projected };
  /// How the front measures the angle at a candidate.
  enum class Angle : std::uint8_t { spatial, projected };
  /// What the front starts from: the triangles that three local triangulations share (and single triangles where
  /// there are none), or the paper's one local triangulation per component.
  enum class Seed : std::uint8_t { triangle, paper };
  enum class FillHoles : std::uint8_t { small, none };

  /// Nearest neighbours that normals and local triangulations are taken from; 8..64.
  std::size_t neighbours = 16;
  Star star = Star::restricted;
  Angle angle = Angle::spatial;
  /// Longest edge, as a multiple of the distance to the 6th nearest neighbour; none: no limit but the neighbourhood.
  std::optional<double> max_edge = std::nullopt;
  Seed seed = Seed::triangle;
  FillHoles fill_holes = FillHoles::small;
};

struct LocalDelaunayResult {
  /// Vertex v is point v of the cloud; unused points are in no triangle.
  TriangleMesh mesh;
  std::vector<std::string> warnings;
  front::Statistics statistics;
};

/// @return  an oriented edge- and vertex-manifold mesh whose vertices are points of the cloud, closed parts facing
///          outwards; too_few_points (3 needed), collinear, cancelled, out_of_memory.
/// @cost    O(V) for points on surfaces.
Result<LocalDelaunayResult> local_delaunay(const PointCloud& cloud, const LocalDelaunayParameters& parameters,
                                           Context& context);

}  // namespace surfaced
