// Source: M. Kazhdan, M. Bolitho, H. Hoppe, "Poisson surface reconstruction", SGP 2006, as implemented by CGAL's
// Poisson_surface_reconstruction_3 on a Delaunay triangulation; meshed after J.-D. Boissonnat, S. Oudot, "Provably good
// sampling and meshing of surfaces", Graphical Models 67 (2005).
#include <algorithm>
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

/// One point in every cell of a coarse grid.
Result<std::vector<std::size_t>> seeds_of(const PointCloud& cloud, double spacing, Context& context) {
  constexpr double kCell = 8;
  PointCloud bare;
  bare.positions = cloud.positions;
  const Result<PointCloud> sample = sampled(bare, kCell * spacing, context);
  if (!sample) return sample.error();
  std::vector<std::size_t> seeds;
  for (const VertexIndex v : nearest_points(cloud.positions, sample->positions, context.threads()).index) {
    seeds.push_back(v);
  }
  return seeds;
}

/// Drops triangles that are further from the points than `reach`, measured at corners and centre.
void trim(const PointCloud& cloud, double reach, TriangleMesh& mesh, unsigned threads) {
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
  if (kept.size() == mesh.triangles.size()) return;
  mesh.triangles = std::move(kept);
  baselines::drop_pinched_fans(mesh);
}

Result<TriangleMesh> reconstruct(const PointCloud& cloud, const PoissonParameters& parameters, Context& context) {
  constexpr std::size_t kVerticesPerPoint = 10;
  constexpr std::size_t kVerticesAlways = 5'000;
  const double spacing = spacing_of(cloud.positions, context.threads());
  const Result<std::vector<std::size_t>> seeds = seeds_of(cloud, spacing, context);
  if (!seeds) return seeds.error();
  const LocalFrame frame(cloud.positions);
  const double unit = frame.to_local(spacing);
  TriangleMesh mesh = baselines::poisson_surface(oriented_points(cloud, frame), *seeds,
                                                 {.spacing = unit,
                                                  .facet_radius = parameters.facet_radius * unit,
                                                  .facet_distance = parameters.facet_distance * unit,
                                                  .most_vertices = kVerticesAlways + kVerticesPerPoint * cloud.size()},
                                                 context);
  context.enter("trim", 1);
  for (Point3& p : mesh.positions) p = frame.to_input(p);
  if (parameters.trim) trim(cloud, *parameters.trim * spacing, mesh, context.threads());
  if (mesh.triangles.empty()) {
    throw std::runtime_error("no triangle of its surface was found near the " + std::to_string(cloud.size()) +
                             " points; it needs more points of each part, or a larger trim; other methods take fewer");
  }
  baselines::sort_mesh(mesh);
  baselines::carry_attributes(cloud, mesh, context.threads());
  return mesh;
}

}  // namespace

Result<TriangleMesh> poisson(const PointCloud& cloud, const PoissonParameters& parameters, Context& context) {
  constexpr std::size_t kFewestPoints = 4;
  if (Status enough = baselines::check_points(cloud, kFewestPoints, "Poisson reconstruction"); !enough) {
    return std::move(enough).error();
  }
  const auto run = [&]() -> Result<TriangleMesh> {
    if (!cloud.normals.empty()) return reconstruct(cloud, parameters, context);
    context.enter("normals", 0.2);
    Result<PointCloud> with = with_normals(cloud, NormalFit::jet, parameters.normal_neighbours, context);
    if (!with) return std::move(with).error();
    Result<TriangleMesh> mesh = reconstruct(*with, parameters, context);
    if (mesh) mesh->normals.clear();
    return mesh;
  };
  try {
    return baselines::guarded("Poisson reconstruction", cloud, context, run);
  } catch (const baselines::Flat&) {
    return Error{ErrorCode::coplanar, "the " + std::to_string(cloud.size()) +
                                          " distinct points, or those drawn to begin with, lie in one plane"};
  }
}

}  // namespace surfaced
