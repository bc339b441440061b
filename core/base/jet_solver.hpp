// SPDX-License-Identifier: GPL-3.0-or-later
// Fits by CGAL's Monge_via_jet_fitting, guarded. For the few files that fit jets: nothing else includes it.
#pragma once

#ifndef CGAL_EIGEN3_ENABLED
#error "define CGAL_EIGEN3_ENABLED before anything of CGAL is included"
#endif
#include <CGAL/Eigen_svd.h>
#include <CGAL/Monge_via_jet_fitting.h>
#include <CGAL/Simple_cartesian.h>

#include <optional>
#include <vector>

namespace surfaced {

/// Thrown where the points fit no jet.
struct NoJet {};

/// CGAL's solver with its precondition asked. Eigen's decomposition of a matrix that is not finite has no rank, and
/// what CGAL then solves with is memory that nobody wrote.
struct JetSolver {
  using FT = CGAL::Eigen_svd::FT;
  using Vector = CGAL::Eigen_svd::Vector;
  using Matrix = CGAL::Eigen_svd::Matrix;

  static FT solve(const Matrix& matrix, Vector& right) {
    if (!matrix.eigen_object().allFinite() || !right.eigen_object().allFinite()) throw NoJet{};
    const FT condition = CGAL::Eigen_svd::solve(matrix, right);
    if (!right.eigen_object().allFinite()) throw NoJet{};
    return condition;
  }
};

template <class Kernel>
using JetFitting = CGAL::Monge_via_jet_fitting<Kernel, CGAL::Simple_cartesian<double>, JetSolver>;

/// The jet of degree 2 at the first of the points, with as much of its form as CGAL's `form_degree` gives. None where
/// they determine none: fewer than 6, several in one place up to rounding, all on a line.
template <class Kernel>
std::optional<typename JetFitting<Kernel>::Monge_form> jet_of(const std::vector<typename Kernel::Point_3>& points,
                                                              std::size_t form_degree) {
  constexpr std::size_t kDegree = 2;
  constexpr std::size_t kCoefficients = 6;
  if (points.size() < kCoefficients) return std::nullopt;
  try {
    JetFitting<Kernel> fitting;
    return fitting(points.begin(), points.end(), kDegree, form_degree);
  } catch (const NoJet&) {
    return std::nullopt;
  } catch (const CGAL::Failure_exception&) {
    return std::nullopt;  // a quadric so steep that the frame on it has no inverse
  }
}

}  // namespace surfaced
