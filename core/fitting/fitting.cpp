// SPDX-License-Identifier: GPL-3.0-or-later
#include "fitting/fitting.hpp"

#define CGAL_EIGEN3_ENABLED
#include <CGAL/Eigen_svd.h>
#include <CGAL/Monge_via_jet_fitting.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/linear_least_squares_fitting_3.h>

#include <Eigen/QR>
#include <cmath>
#include <vector>

#include "base/vectors.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;

/// Thrown where the points fit no jet.
struct NoJet {};

constexpr std::size_t kDegree = 2;
constexpr int kCoefficients = 6;

/// Least squares as CGAL's fitting asks for them: by QR with pivoting, which is faster than CGAL's own solver, by
/// that (singular values) where the points leave the quadric free. Eigen's decomposition of a matrix that is
/// not finite has no rank, and what CGAL then solves with is memory that nobody wrote.
struct JetSolver {
  using FT = CGAL::Eigen_svd::FT;
  using Vector = CGAL::Eigen_svd::Vector;
  using Matrix = CGAL::Eigen_svd::Matrix;

  static FT solve(const Matrix& matrix, Vector& right) {
    if (!matrix.eigen_object().allFinite() || !right.eigen_object().allFinite()) throw NoJet{};
    const FT condition = solved(matrix, right);
    if (!right.eigen_object().allFinite()) throw NoJet{};
    return condition;
  }

 private:
  static FT solved(const Matrix& matrix, Vector& right) {
    const auto& m = matrix.eigen_object();
    if (m.cols() == kCoefficients) {
      const Eigen::ColPivHouseholderQR<Eigen::Matrix<FT, Eigen::Dynamic, kCoefficients>> qr(m);
      if (qr.isInjective()) {
        right.eigen_object() = qr.solve(Vector::EigenType(right.eigen_object()));
        return qr.maxPivot() / std::abs(qr.matrixQR()(kCoefficients - 1, kCoefficients - 1));
      }
    }
    return CGAL::Eigen_svd::solve(matrix, right);
  }
};

using Fitting = CGAL::Monge_via_jet_fitting<Kernel, Kernel, JetSolver>;

std::vector<Kernel::Point_3> library_points(std::span<const Point3> points) {
  std::vector<Kernel::Point_3> result;
  result.reserve(points.size());
  for (const Point3& p : points) result.emplace_back(p[0], p[1], p[2]);
  return result;
}

Point3 vector_of(const Kernel::Vector_3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

std::optional<Point3> normal_of_plane(std::span<const Point3> points) {
  const auto near = library_points(points);
  Kernel::Plane_3 plane;
  CGAL::linear_least_squares_fitting_3(near.begin(), near.end(), plane, CGAL::Dimension_tag<0>());
  return direction_of(vector_of(plane.orthogonal_vector()));
}

std::optional<Jet> jet_of(std::span<const Point3> points, JetForm form) {
  if (points.size() < static_cast<std::size_t>(kCoefficients)) return std::nullopt;
  const auto near = library_points(points);
  try {
    Fitting fitting;
    const auto fitted = fitting(near.begin(), near.end(), kDegree, form == JetForm::curvatures ? 2 : 1);
    const auto normal = direction_of(vector_of(fitted.normal_direction()));
    if (!normal) return std::nullopt;
    Jet jet{.origin = {fitted.origin().x(), fitted.origin().y(), fitted.origin().z()}, .normal = *normal};
    if (form == JetForm::curvatures) jet.curvatures = {fitted.principal_curvatures(0), fitted.principal_curvatures(1)};
    return jet;
  } catch (const NoJet&) {
    return std::nullopt;
  } catch (const CGAL::Failure_exception&) {
    return std::nullopt;  // a quadric so steep that the frame on it has no inverse
  }
}

}  // namespace surfaced
