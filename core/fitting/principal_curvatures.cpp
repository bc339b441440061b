// SPDX-License-Identifier: GPL-3.0-or-later
// Source: F. Cazals, M. Pouget, "Estimating differential quantities using polynomial fitting of osculating jets",
// Computer Aided Geometric Design 22 (2005). What jet_of gets of CGAL, for the certificate, which needs nothing but
// curvatures of every vertex of a mesh: by normal equations, where they are well conditioned.
#include <Eigen/Dense>
#include <cmath>

#include "base/vectors.hpp"
#include "fitting/fitting.hpp"

namespace surfaced {
namespace {

constexpr int kCoefficients = 6;
using Quadric = Eigen::Matrix<double, kCoefficients, 1>;
using Normal = Eigen::Matrix<double, kCoefficients, kCoefficients>;

/// Where the squares of singular values differ by more than this, half of the digits may be lost.
constexpr double kLeastPivot = 1e-8;

/// A frame whose third axis is the direction of least extent.
std::optional<Eigen::Matrix3d> frame_of(std::span<const Point3> points) {
  Point3 mean{};
  for (const Point3& p : points) mean += (1 / static_cast<double>(points.size())) * p;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Point3& p : points) {
    const Eigen::Vector3d d(p[0] - mean[0], p[1] - mean[1], p[2] - mean[2]);
    spread.noalias() += d * d.transpose();
  }
  if (!spread.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  if (axes.info() != Eigen::Success) return std::nullopt;
  return axes.eigenvectors().rowwise().reverse();
}

/// z = q0 + q1 x + q2 y + q3 x²/2 + q4 x y + q5 y²/2 about the first point.
std::optional<Quadric> quadric_of(std::span<const Point3> points, const Eigen::Matrix3d& frame) {
  Normal left = Normal::Zero();
  Quadric right = Quadric::Zero();
  for (const Point3& p : points) {
    const Eigen::Vector3d d(p[0] - points[0][0], p[1] - points[0][1], p[2] - points[0][2]);
    const Eigen::Vector3d local = frame.transpose() * d;
    Quadric row;
    row << 1, local[0], local[1], local[0] * local[0] / 2, local[0] * local[1], local[1] * local[1] / 2;
    left.noalias() += row * row.transpose();
    right.noalias() += local[2] * row;
  }
  const Eigen::LDLT<Normal> solver(left);
  const Quadric pivots = solver.vectorD();
  if (!(pivots.minCoeff() > kLeastPivot * pivots.maxCoeff())) return std::nullopt;
  return Quadric(solver.solve(right));
}

/// Eigenvalues of the shape operator at the origin of a graph.
std::array<double, 2> curvatures_of(const Quadric& q) {
  const double e = 1 + q[1] * q[1];
  const double f = q[1] * q[2];
  const double g = 1 + q[2] * q[2];
  const double area2 = e * g - f * f;
  const double length = std::sqrt(1 + q[1] * q[1] + q[2] * q[2]);
  const double mean = (e * q[5] - 2 * f * q[4] + g * q[3]) / (2 * area2 * length);
  const double gauss = (q[3] * q[5] - q[4] * q[4]) / (area2 * length * length);
  const double half = std::sqrt(std::max(0.0, mean * mean - gauss));
  return {mean + half, mean - half};
}

}  // namespace

std::optional<std::array<double, 2>> principal_curvatures(std::span<const Point3> points) {
  if (points.size() < static_cast<std::size_t>(kCoefficients)) return std::nullopt;
  const std::optional<Eigen::Matrix3d> frame = frame_of(points);
  if (const auto quadric = frame ? quadric_of(points, *frame) : std::nullopt) return curvatures_of(*quadric);
  const std::optional<Jet> jet = jet_of(points, JetForm::curvatures);
  return jet ? std::optional(jet->curvatures) : std::nullopt;
}

}  // namespace surfaced
