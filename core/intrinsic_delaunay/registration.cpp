// SPDX-License-Identifier: GPL-3.0-or-later
// Source: paper 3, §3.2; P. J. Besl, N. D. McKay, "A method for registration of 3-D shapes", PAMI 14 (1992); W. Kabsch,
// Acta Cryst. A32 (1976).
#include "intrinsic_delaunay/registration.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "base/vectors.hpp"

namespace surfaced::idt {
namespace {

constexpr int kSteps = 10;

/// Which moved point is nearest to each target; patches have some twenty points, so all are compared.
std::vector<std::size_t> match(std::span<const Point3> target, const std::vector<Point3>& moved, double& rms) {
  std::vector<std::size_t> nearest(target.size(), 0);
  double sum = 0;
  for (std::size_t j = 0; j < target.size(); ++j) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const Point3 d = moved[i] - target[j];
      if (dot(d, d) >= least) continue;
      least = dot(d, d);
      nearest[j] = i;
    }
    sum += least;
  }
  rms = std::sqrt(sum / static_cast<double>(target.size()));
  return nearest;
}

/// Turns and shifts all points so that the matched ones come nearest to their targets.
bool step(std::span<const Point3> target, const std::vector<std::size_t>& nearest, std::vector<Point3>& moved) {
  const double share = 1 / static_cast<double>(target.size());
  Point3 to{};
  Point3 from{};
  for (std::size_t j = 0; j < target.size(); ++j) {
    to += share * target[j];
    from += share * moved[nearest[j]];
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t j = 0; j < target.size(); ++j) {
    const Point3 a = moved[nearest[j]] - from;
    const Point3 b = target[j] - to;
    covariance += Eigen::Vector3d(a[0], a[1], a[2]) * Eigen::RowVector3d(b[0], b[1], b[2]);
  }
  if (!covariance.allFinite()) return false;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixV() * svd.matrixU().transpose()).determinant() < 0 ? -1 : 1);
  const Eigen::Matrix3d turn = svd.matrixV() * signs.asDiagonal() * svd.matrixU().transpose();
  for (Point3& p : moved) {
    const Point3 d = p - from;
    const Eigen::Vector3d t = turn * Eigen::Vector3d(d[0], d[1], d[2]);
    p = to + Point3{t[0], t[1], t[2]};
  }
  return true;
}

std::optional<Aligned> align_from(std::span<const Point3> target, std::vector<Point3> moved) {
  Aligned best;
  std::vector<std::size_t> nearest = match(target, moved, best.rms);
  best.points = moved;
  for (int i = 0; i < kSteps; ++i) {
    if (!step(target, nearest, moved)) return std::nullopt;
    double rms = 0;
    nearest = match(target, moved, rms);
    if (!(rms < best.rms)) break;
    best = {moved, rms};
  }
  return best;
}

}  // namespace

std::optional<Aligned> align(std::span<const Point3> target, const LocalShape& target_shape,
                             std::span<const Point3> patch, const LocalShape& patch_shape) {
  if (target.empty() || patch.empty()) return std::nullopt;
  std::optional<Aligned> best;
  for (const double turn : {1.0, -1.0}) {  // by half a turn about the normal; frames are right-handed
    std::vector<Point3> moved;
    for (const Point3& p : patch) {
      const Point3 d = p - patch_shape.origin;
      moved.push_back(target_shape.origin + (turn * dot(d, patch_shape.frame[0])) * target_shape.frame[0] +
                      (turn * dot(d, patch_shape.frame[1])) * target_shape.frame[1] +
                      dot(d, patch_shape.frame[2]) * target_shape.frame[2]);
    }
    std::optional<Aligned> aligned = align_from(target, std::move(moved));
    if (aligned && (!best || aligned->rms < best->rms)) best = std::move(aligned);
  }
  return best;
}

}  // namespace surfaced::idt
