// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: Laplacians of a patch and Dirichlet problems on it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hole_filling/patch.hpp"

namespace surfaced::filling {

/// An off-diagonal pair of entries -weight of a symmetric Laplacian; rows add up to 0.
struct WeightedEdge {
  std::uint32_t a;
  std::uint32_t b;
  double weight;
};

/// Half the sum of the cotangents opposite to every edge: the Dirichlet energy of functions linear on the triangles.
std::vector<WeightedEdge> cotangent_weights(const Patch& patch);

/// Half the cotangent of the angle opposite to edge i -> i+1 of the triangle; 0 for a degenerate triangle.
std::array<double, 3> half_cotangents(const Patch& patch, const Corners& triangle);

/// Belkin's operator (paper 3, equation 4) made symmetric: A_a A_b exp(-d²/4h) between points of which one is among the
/// 16 nearest of the other, A a third of the incident area, h the square of the mean distance to them.
std::vector<WeightedEdge> belkin_weights(const Patch& patch);

/// 1 for every edge.
std::vector<WeightedEdge> uniform_weights(const Patch& patch);

using Weights = std::vector<WeightedEdge> (*)(const Patch&);

/// Solves L f = rhs at all points but the first known.size(), where f is known; three functions at once, one per
/// coordinate. Direct (Eigen's LDLT) up to 50,000 unknowns, above by conjugate gradients with an incomplete Cholesky
/// factor to a residual of 1e-10.
/// @param rhs  as long as the patch has points, or empty for zeros (f is then harmonic).
/// @return     f at all points; none unless the matrix is positive definite and the solution finite.
std::optional<std::vector<Point3>> solve_dirichlet(std::size_t points, std::span<const WeightedEdge> weights,
                                                   std::span<const Point3> known, std::span<const Point3> rhs);

}  // namespace surfaced::filling
