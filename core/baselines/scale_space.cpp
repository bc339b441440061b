// SPDX-License-Identifier: GPL-3.0-or-later
// Source: J. Digne, J.-M. Morel, C.-M. Souzani, C. Lartigue, "Scale space meshing of raw data point sets", Computer
// Graphics Forum 30 (2011); the smoothing operator as implemented by CGAL's Scale_space_reconstruction_3.
#define CGAL_EIGEN3_ENABLED
#include <CGAL/Scale_space_reconstruction_3/Weighted_PCA_smoother.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "baselines/method.hpp"
#include "baselines/watched_kernel.hpp"
#include "preparing/preparing.hpp"

namespace surfaced {
namespace {

using baselines::WatchedKernel;

/// Eigenvectors of a covariance matrix, ascending. Iterated: Eigen's direct solver, which CGAL's own traits call, uses
/// functions of the C library whose last bits differ between machines.
struct Diagonalize {
  static bool diagonalize_selfadjoint_covariance_matrix(const std::array<double, 6>& upper,
                                                        std::array<double, 3>& values, std::array<double, 9>& vectors) {
    Eigen::Matrix3d matrix;
    matrix << upper[0], upper[1], upper[2], upper[1], upper[3], upper[4], upper[2], upper[4], upper[5];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix);
    Eigen::Map<Eigen::Vector3d>(values.data()) = solver.eigenvalues();
    Eigen::Map<Eigen::Matrix3d>(vectors.data()) = solver.eigenvectors();
    return solver.info() == Eigen::Success;
  }
};

using Smoother =
    CGAL::Scale_space_reconstruction_3::Weighted_PCA_smoother<WatchedKernel, Diagonalize, CGAL::Sequential_tag>;

/// The points after some steps of the scale space, in the order of the cloud.
RawCloud coarser(const PointCloud& cloud, const ScaleSpaceParameters& parameters, Context& context) {
  constexpr unsigned kSampledForRadius = 300;
  const LocalFrame frame(cloud.positions);
  std::vector<WatchedKernel::Point_3> points;
  points.reserve(cloud.size());
  for (const Point3& p : cloud.positions) {
    const Point3 local = frame.to_local(p);
    points.emplace_back(local[0], local[1], local[2]);
  }
  Smoother smooth(static_cast<unsigned>(std::min(parameters.neighbours, cloud.size() - 1)), kSampledForRadius);
  for (std::size_t step = 0; step < parameters.iterations; ++step) {
    stop_if_cancelled(context);
    smooth(points.begin(), points.end());
    context.report(static_cast<double>(step + 1) / static_cast<double>(parameters.iterations));
  }
  RawCloud raw;
  raw.positions.reserve(points.size());
  for (const WatchedKernel::Point_3& p : points) raw.positions.push_back({p.x(), p.y(), p.z()});
  return raw;
}

/// Triangles of the smoothed points as triangles of the points they came from; of points that were smoothed into one
/// the first stands for all.
std::vector<Triangle> carried_back(const std::vector<Triangle>& triangles, const PointCloud& smoothed) {
  std::vector<VertexIndex> origin(smoothed.size());
  for (std::size_t v = smoothed.input_to_vertex.size(); v-- > 0;) origin[smoothed.input_to_vertex[v]] = VertexIndex(v);
  std::vector<Triangle> result;
  result.reserve(triangles.size());
  for (const Triangle& t : triangles) result.push_back({origin[t[0]], origin[t[1]], origin[t[2]]});
  return result;
}

/// Asked of the input, exactly: smoothing moves points off a line by a rounding.
bool all_on_a_line(const std::vector<Point3>& positions) {
  const auto exact = [](const Point3& p) { return baselines::ExactKernel::Point_3(p[0], p[1], p[2]); };
  return std::ranges::all_of(
      positions, [&](const Point3& p) { return CGAL::collinear(exact(positions[0]), exact(positions[1]), exact(p)); });
}

Result<TriangleMesh> reconstruct(const PointCloud& cloud, const ScaleSpaceParameters& parameters, Context& context) {
  context.enter("scale-space", 0.4);
  const Result<PointCloud> smoothed = make_cloud(coarser(cloud, parameters, context), context.threads());
  if (!smoothed) return smoothed.error();
  const Result<TriangleMesh> coarse = advancing_front(*smoothed, {}, context);
  if (!coarse) return coarse.error();
  TriangleMesh mesh{cloud.positions, carried_back(coarse->triangles, *smoothed), cloud.normals, cloud.colors};
  orient_outwards(mesh);
  sort_triangles(mesh);
  return mesh;
}

}  // namespace

Result<TriangleMesh> scale_space(const PointCloud& cloud, const ScaleSpaceParameters& parameters, Context& context) {
  constexpr std::size_t kFewestPoints = 3;
  if (Status enough = baselines::check_points(cloud, kFewestPoints, "scale space"); !enough) {
    return std::move(enough).error();
  }
  if (all_on_a_line(cloud.positions)) {
    return Error{ErrorCode::collinear, "all " + std::to_string(cloud.size()) + " distinct points lie on one line"};
  }
  return baselines::guarded("scale space", cloud, context,
                            [&]() -> Result<TriangleMesh> { return reconstruct(cloud, parameters, context); });
}

}  // namespace surfaced
