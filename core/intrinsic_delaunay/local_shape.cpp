// SPDX-License-Identifier: GPL-3.0-or-later
#include "intrinsic_delaunay/local_shape.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/vectors.hpp"

namespace surfaced::idt {
namespace {

Eigen::Vector3d vector_of(const Point3& p) { return {p[0], p[1], p[2]}; }
Point3 point_of(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

/// The principal axes of the points, the least last.
std::optional<std::array<Point3, 3>> principal_frame(std::span<const Point3> points, const Point3& up) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Point3& p : points) centre += vector_of(p) / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Point3& p : points) scatter += (vector_of(p) - centre) * (vector_of(p) - centre).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);
  if (axes.info() != Eigen::Success || !(axes.eigenvalues()[1] > 0)) return std::nullopt;
  Eigen::Vector3d normal = axes.eigenvectors().col(0);
  if (normal.dot(vector_of(up)) < 0) normal = -normal;
  const Eigen::Vector3d first = axes.eigenvectors().col(2);
  return std::array<Point3, 3>{point_of(first), point_of(normal.cross(first)), point_of(normal)};
}

}  // namespace

std::optional<LocalShape> fit_shape(std::span<const Point3> points, const Point3& origin, const Point3& up) {
  if (points.size() < 3) return std::nullopt;
  const auto frame = principal_frame(points, up);
  if (!frame) return std::nullopt;
  double reach = 0;
  for (const Point3& p : points) reach = std::max(reach, norm(p - origin));
  if (!(reach > 0) || !std::isfinite(reach)) return std::nullopt;
  Eigen::Matrix<double, Eigen::Dynamic, 6> rows(static_cast<Eigen::Index>(points.size()), 6);
  Eigen::VectorXd heights(rows.rows());
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const Point3 d = (1 / reach) * (points[static_cast<std::size_t>(i)] - origin);  // lengths of order 1
    const double x = dot(d, (*frame)[0]);
    const double y = dot(d, (*frame)[1]);
    rows.row(i) << 1, x, y, x * x, x * y, y * y;
    heights[i] = dot(d, (*frame)[2]);
  }
  LocalShape shape{origin, *frame, {}};
  const Eigen::ColPivHouseholderQR<decltype(rows)> factors(rows);
  if (factors.rank() < 6) {
    shape.c[0] = heights.mean() * reach;
    return shape;
  }
  const Eigen::VectorXd c = factors.solve(heights);
  shape.c = {c[0] * reach, c[1], c[2], c[3] / reach, c[4] / reach, c[5] / reach};
  return shape;
}

Point3 LocalShape::above(const Point3& p) const {
  const double x = dot(p - origin, frame[0]);
  const double y = dot(p - origin, frame[1]);
  const double z = c[0] + c[1] * x + c[2] * y + c[3] * x * x + c[4] * x * y + c[5] * y * y;
  return origin + x * frame[0] + y * frame[1] + z * frame[2];
}

LocalShape::Curvature LocalShape::curvature_at(const Point3& p) const {
  const double x = dot(p - origin, frame[0]);
  const double y = dot(p - origin, frame[1]);
  const double zx = c[1] + 2 * c[3] * x + c[4] * y;
  const double zy = c[2] + c[4] * x + 2 * c[5] * y;
  const double zxx = 2 * c[3];
  const double zxy = c[4];
  const double zyy = 2 * c[5];
  const double g = 1 + zx * zx + zy * zy;
  return {((1 + zy * zy) * zxx - 2 * zx * zy * zxy + (1 + zx * zx) * zyy) / (2 * g * std::sqrt(g)),
          (zxx * zyy - zxy * zxy) / (g * g)};
}

}  // namespace surfaced::idt
