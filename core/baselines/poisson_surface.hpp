// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: the surface of CGAL's Poisson_reconstruction_function, in a frame of the caller's.
#pragma once

#include <cstddef>
#include <vector>

#include "base/base.hpp"
#include "mesh/mesh.hpp"

namespace surfaced::baselines {

struct OrientedPoints {
  std::vector<Point3> positions;
  /// Of length 1.
  std::vector<Point3> normals;
};

struct SurfaceOptions {
  /// Length to which the other two lengths of Poisson reconstruction relate.
  double spacing = 0;
  /// Largest radius of the balls around facets, and largest distance from a facet's centre to the surface.
  double facet_radius = 0;
  double facet_distance = 0;
  /// Vertices at which the meshing gives up.
  std::size_t most_vertices = 0;
};

/// Thrown for points, or a random half thousand of them, in one plane.
struct Flat {};

/// The zero set as triangles that face outwards; empty if none of it is near the points.
/// @throws Cancelled, Flat, std::exception.
TriangleMesh poisson_surface(const OrientedPoints& points, const SurfaceOptions& options, Context& context);

}  // namespace surfaced::baselines
