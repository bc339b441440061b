// SPDX-License-Identifier: GPL-3.0-or-later
// Source: paper 3, §3.3, read with W. Zhao, S. Gao, H. Lin, "A robust hole-filling algorithm for triangular mesh", The
// Visual Computer 23 (2007), whose recipe it resembles.
#include "hole_filling/refinement.hpp"

#include <algorithm>
#include <cmath>

#include "base/vectors.hpp"
#include "hole_filling/laplacian.hpp"

namespace surfaced::filling {
namespace {

/// Rounds of normals, turning and solving: the first knows the surface only from outside the hole.
constexpr int kRounds = 3;

Point3 area_vector(const Patch& patch, const Corners& t) {
  const Point3& a = patch.points[t[0]];
  return cross(patch.points[t[1]] - a, patch.points[t[2]] - a);
}

/// Adds to the normals at the corners those of the patch, weighted by angles.
std::vector<Point3> normals_of_both_sides(const Patch& patch, const Hole& hole) {
  std::vector<Point3> normals = hole.normals;
  for (const Corners& t : patch.triangles) {
    const auto normal = direction_of(area_vector(patch, t));
    if (!normal) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      if (t[i] >= normals.size()) continue;
      const Point3 a = patch.points[t[(i + 1) % 3]] - patch.points[t[i]];
      const Point3 b = patch.points[t[(i + 2) % 3]] - patch.points[t[i]];
      normals[t[i]] += std::atan2(norm(cross(a, b)), dot(a, b)) * *normal;
    }
  }
  return normals;
}

/// Unit normals at all points, harmonic between the corners; where they vanish, the mean of the corners'.
std::vector<Point3> harmonic_normals(const Patch& patch, std::vector<Point3> at_corners, Weights harmonic) {
  Point3 sum{};
  for (Point3& n : at_corners) {
    n = direction_of(n).value_or(Point3{});
    sum += n;
  }
  const Point3 mean = direction_of(sum).value_or(Point3{});
  std::vector<Point3> normals = spread_harmonically(patch, at_corners, harmonic);
  for (Point3& n : normals) n = direction_of(n).value_or(mean);
  return normals;
}

/// The triangle's edges i -> i+1 after it was turned about its centre by the least angle that gives it the normal
/// `wanted`.
std::array<Point3, 3> turned_edges(const Patch& patch, const Corners& t, const std::optional<Point3>& wanted) {
  std::array<Point3, 3> edges;
  for (std::size_t i = 0; i < 3; ++i) edges[i] = patch.points[t[(i + 1) % 3]] - patch.points[t[i]];
  const auto normal = direction_of(area_vector(patch, t));
  if (!normal || !wanted) return edges;
  const Point3 about = cross(*normal, *wanted);
  const auto axis = direction_of(about);
  if (!axis) return edges;  // it has that normal, or the opposite one, to which no turn is the least
  for (Point3& e : edges) e = turned(e, *axis, dot(*normal, *wanted), norm(about));
  return edges;
}

/// The divergence of the guidance field: what L f shall be for edges like those of the turned triangles.
std::vector<Point3> divergence(const Patch& patch, const std::vector<Point3>& normals) {
  std::vector<Point3> rhs(patch.points.size(), Point3{});
  for (const Corners& t : patch.triangles) {
    const auto wanted = direction_of(normals[t[0]] + normals[t[1]] + normals[t[2]]);
    const std::array<Point3, 3> edges = turned_edges(patch, t, wanted);
    const std::array<double, 3> weights = half_cotangents(patch, t);
    for (std::size_t i = 0; i < 3; ++i) {
      rhs[t[i]] += -weights[i] * edges[i];
      rhs[t[(i + 1) % 3]] += weights[i] * edges[i];
    }
  }
  return rhs;
}

std::span<const Point3> corners_of(const Patch& patch, const Hole& hole) {
  return std::span(patch.points).first(hole.corners.size());
}

void take(Patch& patch, std::optional<std::vector<Point3>> points) {
  if (points) patch.points = std::move(*points);
}

void fit_to_normals(Patch& patch, const Hole& hole, Weights harmonic) {
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Point3> known = round == 0 ? hole.normals : normals_of_both_sides(patch, hole);
    const std::vector<Point3> normals = harmonic_normals(patch, std::move(known), harmonic);
    take(patch, solve_dirichlet(patch.points.size(), cotangent_weights(patch), corners_of(patch, hole),
                                divergence(patch, normals)));
  }
}

/// The paper's words taken literally: every new point turned by π/2 about its normal through the centre of its
/// neighbours, then Laplace's equation with the printed weights, made symmetric.
void turn_points(Patch& patch, const Hole& hole) {
  const std::vector<Point3> normals = harmonic_normals(patch, hole.normals, cotangent_weights);
  std::vector<Point3> centres(patch.points.size(), Point3{});
  std::vector<double> degrees(patch.points.size(), 0);
  for (const WeightedEdge& e : belkin_weights(patch)) {
    centres[e.a] += patch.points[e.b];
    centres[e.b] += patch.points[e.a];
    ++degrees[e.a];
    ++degrees[e.b];
  }
  for (std::size_t i = hole.corners.size(); i < patch.points.size(); ++i) {
    if (!(degrees[i] > 0)) continue;
    const Point3 centre = (1 / degrees[i]) * centres[i];
    patch.points[i] = centre + turned(patch.points[i] - centre, normals[i], 0, 1);
  }
  take(patch, solve_dirichlet(patch.points.size(), belkin_weights(patch), corners_of(patch, hole), {}));
}

}  // namespace

std::vector<Point3> spread_harmonically(const Patch& patch, std::span<const Point3> at_corners, Weights harmonic) {
  for (const auto& weights : {harmonic(patch), uniform_weights(patch)}) {
    if (auto values = solve_dirichlet(patch.points.size(), weights, at_corners, {})) return std::move(*values);
  }
  // No system is left: the mean of the corners everywhere.
  Point3 mean{};
  for (const Point3& value : at_corners) mean += (1 / static_cast<double>(at_corners.size())) * value;
  std::vector<Point3> values(at_corners.begin(), at_corners.end());
  values.resize(patch.points.size(), mean);
  return values;
}

void refine(Patch& patch, const Hole& hole, Rotation rotation, Weights harmonic) {
  switch (rotation) {
    case Rotation::normal:
      fit_to_normals(patch, hole, harmonic);
      return;
    case Rotation::none:
      take(patch, solve_dirichlet(patch.points.size(), harmonic(patch), corners_of(patch, hole), {}));
      return;
    case Rotation::paper:
      turn_points(patch, hole);
      return;
  }
}

}  // namespace surfaced::filling
