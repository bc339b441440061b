// SPDX-License-Identifier: GPL-3.0-or-later
#include "hole_filling/laplacian.hpp"

#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <map>
#include <nanoflann.hpp>

#include "base/vectors.hpp"

namespace surfaced::filling {
namespace {

constexpr std::size_t kMostForDirect = 50'000;
constexpr double kResidual = 1e-10;
/// Neighbours in Belkin's operator.
constexpr std::size_t kNeighbours = 16;

using Matrix = Eigen::SparseMatrix<double>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

struct System {
  Matrix matrix;
  Columns rhs;
};

/// The rows of the unknown points, with what is known brought to the right-hand side.
System system_of(std::size_t points, std::span<const WeightedEdge> weights, std::span<const Point3> known,
                 std::span<const Point3> rhs) {
  const std::size_t first = known.size();
  const auto unknowns = static_cast<Eigen::Index>(points - first);
  System system{Matrix(unknowns, unknowns), Columns::Zero(unknowns, 3)};
  const auto row = [&](std::size_t point) { return static_cast<int>(point - first); };
  for (std::size_t i = first; i < points && !rhs.empty(); ++i) {
    for (int k = 0; k < 3; ++k) system.rhs(row(i), k) = rhs[i][static_cast<std::size_t>(k)];
  }
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(4 * weights.size());
  const auto half = [&](std::uint32_t i, std::uint32_t j, double weight) {
    if (i < first) return;
    entries.emplace_back(row(i), row(i), weight);
    if (j >= first) {
      entries.emplace_back(row(i), row(j), -weight);
      return;
    }
    for (int k = 0; k < 3; ++k) system.rhs(row(i), k) += weight * known[j][static_cast<std::size_t>(k)];
  };
  for (const WeightedEdge& e : weights) {
    half(e.a, e.b, e.weight);
    half(e.b, e.a, e.weight);
  }
  system.matrix.setFromTriplets(entries.begin(), entries.end());
  return system;
}

std::optional<Columns> solve_directly(const System& system) {
  const Eigen::SimplicialLDLT<Matrix> factors(system.matrix);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0)) return std::nullopt;
  return Columns(factors.solve(system.rhs));
}

std::optional<Columns> solve_iteratively(const System& system) {
  Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper, Eigen::IncompleteCholesky<double>> solver;
  solver.setTolerance(kResidual);
  solver.compute(system.matrix);
  if (solver.info() != Eigen::Success) return std::nullopt;
  Columns solution = solver.solve(system.rhs);
  if (solver.info() != Eigen::Success) return std::nullopt;
  return solution;
}

std::vector<double> third_of_incident_areas(const Patch& patch) {
  std::vector<double> areas(patch.points.size(), 0);
  for (const Corners& t : patch.triangles) {
    const Point3& a = patch.points[t[0]];
    const double area = norm(cross(patch.points[t[1]] - a, patch.points[t[2]] - a)) / 2;
    for (const std::uint32_t v : t) areas[v] += area / 3;
  }
  return areas;
}

struct PointsAdaptor {
  const std::vector<Point3>& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box& /*unused*/) const {
    return false;
  }
};

/// The 16 nearest points of each, itself left out.
std::vector<std::vector<std::uint32_t>> nearest_of_all(const std::vector<Point3>& points) {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointsAdaptor>, PointsAdaptor,
                                                   3, std::uint32_t>;
  const PointsAdaptor adaptor{points};
  const Tree tree(3, adaptor);
  std::vector<std::vector<std::uint32_t>> result(points.size());
  std::array<std::uint32_t, kNeighbours + 1> found{};
  std::array<double, kNeighbours + 1> squares{};
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::size_t count = tree.knnSearch(points[i].data(), kNeighbours + 1, found.data(), squares.data());
    for (std::size_t k = 0; k < count && result[i].size() < kNeighbours; ++k) {
      if (found[k] != i) result[i].push_back(found[k]);
    }
  }
  return result;
}

}  // namespace

std::array<double, 3> half_cotangents(const Patch& patch, const Corners& t) {
  std::array<double, 3> result{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Point3& apex = patch.points[t[(i + 2) % 3]];
    const Point3 a = patch.points[t[i]] - apex;
    const Point3 b = patch.points[t[(i + 1) % 3]] - apex;
    const double cotangent = dot(a, b) / (2 * norm(cross(a, b)));
    if (!std::isfinite(cotangent)) return {};
    result[i] = cotangent;
  }
  return result;
}

std::vector<WeightedEdge> cotangent_weights(const Patch& patch) {
  std::vector<WeightedEdge> weights;
  weights.reserve(3 * patch.triangles.size());
  for (const Corners& t : patch.triangles) {
    const std::array<double, 3> half = half_cotangents(patch, t);
    for (std::size_t i = 0; i < 3; ++i) weights.push_back({t[i], t[(i + 1) % 3], half[i]});
  }
  return weights;
}

std::vector<WeightedEdge> belkin_weights(const Patch& patch) {
  const std::vector<double> areas = third_of_incident_areas(patch);
  const auto nearest = nearest_of_all(patch.points);
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> pairs;
  double sum = 0;
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < nearest.size(); ++i) {
    for (const std::uint32_t j : nearest[i]) {
      const double distance = norm(patch.points[j] - patch.points[i]);
      sum += distance;
      ++count;
      pairs.emplace(std::minmax(i, j), distance);
    }
  }
  const double mean = sum / static_cast<double>(std::max<std::size_t>(count, 1));
  const double square = mean * mean;
  std::vector<WeightedEdge> weights;
  weights.reserve(pairs.size());
  for (const auto& [pair, distance] : pairs) {
    const double decay = std::exp(-distance * distance / (4 * square));
    weights.push_back({pair.first, pair.second, areas[pair.first] * areas[pair.second] / (square * square) * decay});
  }
  return weights;
}

std::vector<WeightedEdge> uniform_weights(const Patch& patch) {
  std::vector<WeightedEdge> weights;
  for (const Corners& t : patch.triangles) {
    for (std::size_t i = 0; i < 3; ++i) weights.push_back({t[i], t[(i + 1) % 3], 1});
  }
  return weights;
}

std::optional<std::vector<Point3>> solve_dirichlet(std::size_t points, std::span<const WeightedEdge> weights,
                                                   std::span<const Point3> known, std::span<const Point3> rhs) {
  std::vector<Point3> result(known.begin(), known.end());
  if (points == known.size()) return result;
  const System system = system_of(points, weights, known, rhs);
  const bool direct = points - known.size() <= kMostForDirect;
  const std::optional<Columns> solution = direct ? solve_directly(system) : solve_iteratively(system);
  if (!solution || !solution->allFinite()) return std::nullopt;
  result.resize(points);
  for (std::size_t i = known.size(); i < points; ++i) {
    const auto row = static_cast<Eigen::Index>(i - known.size());
    result[i] = {(*solution)(row, 0), (*solution)(row, 1), (*solution)(row, 2)};
  }
  return result;
}

}  // namespace surfaced::filling
