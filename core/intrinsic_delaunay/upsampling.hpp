// SPDX-License-Identifier: GPL-3.0-or-later
// Upsampling around the method: part of the room's face, apart from it because it takes the method as a parameter.
#pragma once

#include <functional>
#include <optional>

#include "base/base.hpp"
#include "cloud/cloud.hpp"
#include "mesh/mesh.hpp"

namespace surfaced::idt {

enum class Upsampling : std::uint8_t { jet, paper };

struct UpsamplingStatistics {
  /// ε: no triangle shall have a larger circumradius; no new point comes nearer to another than ε/2.
  double epsilon = 0;
  std::size_t rounds = 0;
  std::size_t points_added = 0;
  /// Of those, taken from a similar patch (`paper` only); the others lie on the jet of their neighbours.
  std::size_t from_patches = 0;
  /// Triangles that are still too large at the end.
  std::size_t large_triangles = 0;
};

struct Upsampled {
  /// The points of the input and the new ones, in canonical order, with normals and colours where the input has them.
  PointCloud cloud;
  /// Its mesh.
  TriangleMesh mesh;
  UpsamplingStatistics statistics;
};

/// Turns a cloud into a mesh with vertex v = point v.
using Reconstruct = std::function<Result<TriangleMesh>(const PointCloud&)>;

/// Adds points where the sampling criterion fails (paper 3, §3.2): at the circumcentres (of obtuse triangles: the
/// middle of the longest edge) of triangles whose circumradius exceeds ε, largest first, moved onto the surface; then
/// builds the mesh anew, until no point can be added. `jet` moves them to the quadric through their neighbours; `paper`
/// to the nearest point of the most similar patch elsewhere, where that fits, else as `jet`. Ends: every new point
/// keeps ε/2 from all others, and there are never more than 4 times the points of the input.
/// @param mesh  reconstruct(cloud).
/// @return  cancelled, or the error of a reconstruction.
Result<Upsampled> upsample(PointCloud cloud, TriangleMesh mesh, double epsilon, Upsampling way,
                           const Reconstruct& reconstruct, Context& context);

/// Triangles whose circumradius exceeds ε, or that have no area.
std::size_t large_triangles(const TriangleMesh& mesh, double epsilon);

/// The 95th percentile of the distance to the 6th nearest neighbour.
double automatic_epsilon(const PointCloud& cloud, Context& context);

}  // namespace surfaced::idt
