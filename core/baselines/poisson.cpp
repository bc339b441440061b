// SPDX-License-Identifier: GPL-3.0-or-later
// Source: M. Kazhdan, M. Bolitho, H. Hoppe, "Poisson surface reconstruction", SGP 2006, as implemented by CGAL's
// Poisson_surface_reconstruction_3 on a Delaunay triangulation; meshed after J.-D. Boissonnat, S. Oudot, "Provably good
// sampling and meshing of surfaces", Graphical Models 67 (2005).
#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "base/vectors.hpp"
#include "baselines/method.hpp"
#include "baselines/poisson_surface.hpp"
#include "preparing/preparing.hpp"

namespace surfaced {
namespace {

using baselines::OrientedPoints;

OrientedPoints oriented_points(const PointCloud& cloud, const LocalFrame& frame) {
  OrientedPoints points;
  for (std::size_t v = 0; v < cloud.size(); ++v) {
    const Normal3& n = cloud.normals[v];
    const Point3 normal{static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])};
    points.positions.push_back(frame.to_local(cloud.positions[v]));
    points.normals.push_back(direction_of(normal).value_or(Point3{0, 0, 1}));
  }
  return points;
}

/// Drops triangles that are further from the points than `reach`, measured at corners and centre.
/// @return  whether there were any.
bool trim(const PointCloud& cloud, double reach, TriangleMesh& mesh, unsigned threads) {
  std::vector<Point3> places = mesh.positions;
  for (const Triangle& t : mesh.triangles) {
    places.push_back((1.0 / 3) * (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]));
  }
  const std::vector<double> distance = nearest_points(cloud.positions, places, threads).distance;
  std::vector<Triangle> kept;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const double farthest =
        std::max({distance[t[0]], distance[t[1]], distance[t[2]], distance[mesh.positions.size() + i]});
    if (farthest <= reach) kept.push_back(t);
  }
  const bool dropped = kept.size() < mesh.triangles.size();
  mesh.triangles = std::move(kept);
  return dropped;
}

/// Drops the triangles at edges where two disagree in orientation: they do where the surface leaves the sphere in which
/// it is looked for, so that not all of its facets are there.
/// @return  whether there were any.
bool drop_disagreeing(TriangleMesh& mesh) {
  const HalfEdges edges(mesh.triangles, mesh.positions.size());
  const auto disagrees = [&](std::size_t t) {
    return std::ranges::any_of(std::array{3 * t, 3 * t + 1, 3 * t + 2}, [&](std::size_t h) {
      return edges.uses(edges.edge_of(HalfEdgeIndex(h))) == 2 && !edges.mate(HalfEdgeIndex(h)).valid();
    });
  };
  std::vector<Triangle> kept;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!disagrees(t)) kept.push_back(mesh.triangles[t]);
  }
  const bool dropped = kept.size() < mesh.triangles.size();
  mesh.triangles = std::move(kept);
  return dropped;
}

/// Points further from all vertices than triangles are large and points scatter: outliers, and parts that are missing.
std::size_t count_left_out(const PointCloud& cloud, const TriangleMesh& mesh, double reach, unsigned threads) {
  const std::vector<double> distance = nearest_points(mesh.positions, cloud.positions, threads).distance;
  return static_cast<std::size_t>(std::ranges::count_if(distance, [&](double d) { return d > reach; }));
}

PoissonResult reconstruct(const PointCloud& cloud, const PoissonParameters& parameters, Context& context) {
  constexpr std::size_t kVerticesPerPoint = 10;
  constexpr std::size_t kVerticesAlways = 5'000;
  // In the local frame: a thousandth of the deviation of a facet, to which places on the surface are found, has to be
  // more than the step of a double.
  constexpr double kLeastSpacing = 0x1p-16;
  const double spacing = spacing_of(cloud.positions, context.threads());
  const LocalFrame frame(cloud.positions);
  const double unit = std::max(kLeastSpacing, frame.to_local(spacing));
  TriangleMesh mesh = baselines::poisson_surface(oriented_points(cloud, frame),
                                                 {.spacing = unit,
                                                  .facet_radius = parameters.facet_radius * unit,
                                                  .facet_distance = parameters.facet_distance * unit,
                                                  .most_vertices = kVerticesAlways + kVerticesPerPoint * cloud.size()},
                                                 context);
  context.enter("trim", 1);
  for (Point3& p : mesh.positions) p = frame.to_input(p);
  const bool trimmed = parameters.trim && trim(cloud, *parameters.trim * spacing, mesh, context.threads());
  if (drop_disagreeing(mesh) || trimmed) baselines::drop_pinched_fans(mesh);
  if (mesh.triangles.empty()) {
    throw std::runtime_error("no triangle of its surface was found near the " + std::to_string(cloud.size()) +
                             " points; it needs more points of each part, or a larger trim; other methods take fewer");
  }
  baselines::sort_mesh(mesh);
  baselines::carry_attributes(cloud, mesh, context.threads());
  const double reach = (parameters.facet_radius + PoissonResult::kLeftOut) * spacing;
  const std::size_t left_out = count_left_out(cloud, mesh, reach, context.threads());
  return {.mesh = std::move(mesh), .points_left_out = left_out};
}

constexpr std::size_t kFewestNeighbours = 9;

/// Neighbourhoods that are small compared to the cloud: a sphere of 20 points lost half of itself to 18 neighbours.
std::size_t neighbours_of_normals(std::size_t points) {
  constexpr std::size_t kNeighbourhoods = 24;
  return std::max(kFewestNeighbours, points / kNeighbourhoods);
}

}  // namespace

Result<PoissonResult> poisson(const PointCloud& cloud, const PoissonParameters& parameters, Context& context) {
  constexpr std::size_t kFewestPoints = 4;
  const bool has_normals = !cloud.normals.empty();
  if (Status enough =
          has_normals ? baselines::check_points(cloud, kFewestPoints, "Poisson reconstruction")
                      : baselines::check_points(cloud, kFewestNeighbours + 1, "Poisson reconstruction without normals");
      !enough) {
    return std::move(enough).error();
  }
  const auto run = [&]() -> Result<PoissonResult> {
    if (has_normals) return reconstruct(cloud, parameters, context);
    context.enter("normals", 0.2);
    const std::size_t neighbours = std::min(parameters.normal_neighbours, neighbours_of_normals(cloud.size()));
    Result<PointCloud> with = with_normals(cloud, NormalFit::jet, neighbours, context);
    if (!with) return std::move(with).error();
    PoissonResult result = reconstruct(*with, parameters, context);
    result.mesh.normals.clear();
    return result;
  };
  try {
    return baselines::guarded("Poisson reconstruction", cloud, context, run);
  } catch (const baselines::Flat&) {
    return Error{ErrorCode::coplanar, "the " + std::to_string(cloud.size()) +
                                          " distinct points, or those drawn to begin with, lie in one plane"};
  }
}

}  // namespace surfaced
