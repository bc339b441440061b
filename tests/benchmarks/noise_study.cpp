// SPDX-License-Identifier: GPL-3.0-or-later
// The tables of docs/noise.md: how far from the truth each method ends on noisy shapes, with and without preparing.
//   build/release/noise_study [POINTS]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "base/vectors.hpp"
#include "preparing/preparing.hpp"
#include "reconstruction/reconstruction.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

double distance_to_torus(const Point3& p) { return std::abs(std::hypot(std::hypot(p[0], p[1]) - 1, p[2]) - 0.3); }
double distance_to_sphere(const Point3& p) { return std::abs(norm(p) - 1); }

std::vector<Point3> noisy_sphere(std::size_t points, std::uint32_t seed, double noise) {
  std::mt19937 random(seed);
  std::normal_distribution<double> component(0, 1);
  std::vector<Point3> all;
  while (all.size() < points) {
    const auto direction = direction_of({component(random), component(random), component(random)});
    if (direction) all.push_back((1 + noise * component(random)) * *direction);
  }
  return all;
}

/// Half the sides of a box: edges and corners, and walls that are 10 to 20 spacings apart.
constexpr Point3 kHalf{1, 0.7, 0.5};

double distance_to_box(const Point3& p) {
  Point3 outside{};
  double inside = -std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double beyond = std::abs(p[axis]) - kHalf[axis];
    outside.at(axis) = std::max(beyond, 0.0);
    inside = std::max(inside, beyond);
  }
  return inside > 0 ? norm(outside) : -inside;
}

std::vector<Point3> noisy_box(std::size_t points, std::uint32_t seed, double noise) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1, 1);
  std::normal_distribution<double> off(0, noise > 0 ? noise : 1);
  std::discrete_distribution<std::size_t> across{1 / kHalf[0], 1 / kHalf[1], 1 / kHalf[2]};
  std::vector<Point3> all;
  for (std::size_t i = 0; i < points; ++i) {
    Point3 p{kHalf[0] * place(random), kHalf[1] * place(random), kHalf[2] * place(random)};
    const std::size_t axis = across(random);
    const double wall = kHalf[axis] + (noise > 0 ? off(random) : 0);
    p.at(axis) = p[axis] < 0 ? -wall : wall;
    all.push_back(p);
  }
  return all;
}

struct Shape {
  const char* name;
  /// Random points of it, with normally distributed noise across the surface.
  std::vector<Point3> (*points)(std::size_t, std::uint32_t seed, double noise);
  double (*distance)(const Point3&);
};
constexpr std::array kShapes{Shape{"torus", testing::random_torus, distance_to_torus},
                             Shape{"box", noisy_box, distance_to_box},
                             Shape{"sphere", noisy_sphere, distance_to_sphere}};

/// Outliers evenly in a box around.
PointCloud noisy(const Shape& shape, std::size_t points, double noise, double outliers) {
  std::vector<Point3> all = shape.points(points, 11, noise);
  const Bounds bounds = bounds_of(shape.points(points, 11, 0));
  for (const Point3& p :
       testing::random_points(static_cast<std::size_t>(std::lround(outliers * static_cast<double>(points))), 12)) {
    const Point3& high = bounds.high;
    all.push_back({1.2 * high[0] * p[0], 1.2 * high[1] * p[1], 1.6 * high[2] * p[2]});
  }
  return *make_cloud(testing::raw_cloud(std::move(all)));
}

/// Outliers at twice the median, then smoothing with as many neighbours as the noise wants.
Result<PointCloud> prepared(const PointCloud& cloud, double noise_in_spacings, Context& context) {
  Result<PointCloud> without = without_outliers(cloud, 2, context);
  if (!without) return without;
  const auto neighbours = static_cast<std::size_t>(std::clamp(24 * (1 + noise_in_spacings), 24.0, 150.0));
  return smoothed(*without, Smoothing::jet, neighbours, context);
}

/// Points spread over the triangles, the more the larger the triangle.
std::vector<Point3> samples_of(const TriangleMesh& mesh, double step) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Point3> samples;
  for (const Triangle& t : mesh.triangles) {
    const Point3& a = mesh.positions[t[0]];
    const Point3 u = mesh.positions[t[1]] - a;
    const Point3 v = mesh.positions[t[2]] - a;
    const double expected = norm(cross(u, v)) / 2 / (step * step);
    for (auto n = static_cast<std::size_t>(expected + unit(random)); n > 0; --n) {
      double x = unit(random);
      double y = unit(random);
      if (x + y > 1) {
        x = 1 - x;
        y = 1 - y;
      }
      samples.push_back({a[0] + x * u[0] + y * v[0], a[1] + x * u[1] + y * v[1], a[2] + x * u[2] + y * v[2]});
    }
  }
  return samples;
}

struct Score {
  bool failed = false;
  bool closed = false;
  double mean = 0;
  double covered = 0;
};

Score score_of(const TriangleMesh& mesh, const Shape& shape, double spacing) {
  constexpr double kNear = 2;
  const std::vector<Point3> samples = samples_of(mesh, spacing);
  if (samples.empty()) return {.failed = true};
  Score score{.closed = topology_of(mesh).closed};
  for (const Point3& p : samples) score.mean += shape.distance(p) / static_cast<double>(samples.size());
  score.mean /= spacing;
  const std::vector<Point3> truth = shape.points(4000, 77, 0);
  for (const double d : nearest_points(samples, truth, 1).distance) {
    if (d < kNear * spacing) score.covered += 1.0 / static_cast<double>(truth.size());
  }
  return score;
}

Score score_of(const MethodInfo& method, const PointCloud& cloud, const Shape& shape, double spacing) {
  Context context(2);
  const auto result = run(cloud, method, *check_parameters(method, Json::object()), context);
  return result ? score_of(result->mesh, shape, spacing) : Score{.failed = true};
}

/// A row of the table: for every method what it scored on each shape.
struct Row {
  double noise = 0;
  double outliers = 0;
  bool prepared = false;
  std::vector<std::vector<Score>> of_method;
};

/// Mean of the distances, least of the coverages.
void print_cell(const std::vector<Score>& scores) {
  double sum = 0;
  double covered = 1;
  std::size_t there = 0;
  bool closed = true;
  for (const Score& score : scores) {
    if (score.failed) continue;
    ++there;
    sum += score.mean;
    covered = std::min(covered, score.covered);
    closed = closed && score.closed;
  }
  if (there == 0) {
    std::printf(" failed |");
    return;
  }
  std::printf(" %.2f", sum / static_cast<double>(there));
  if (covered < 0.95) std::printf(" (%.0f %%)", 100 * covered);
  if (there < scores.size()) std::printf(" %zu failed", scores.size() - there);
  std::printf("%s |", closed && there == scores.size() ? " c" : "");
}

/// Rows of all shapes together, or of one.
void print_table(const std::vector<Row>& rows, std::optional<std::size_t> shape) {
  std::printf("\n%s\n\n| noise | outliers | prepared |", shape ? kShapes.at(*shape).name : "all shapes");
  for (const MethodInfo& method : methods()) std::printf(" %s |", method.id.c_str());
  std::printf("\n|---|---|---|");
  for (std::size_t i = 0; i < methods().size(); ++i) std::printf("---|");
  std::printf("\n");
  for (const Row& row : rows) {
    std::printf("| %.1f | %.0f %% | %s |", row.noise, 100 * row.outliers, row.prepared ? "yes" : "no");
    for (const std::vector<Score>& scores : row.of_method) {
      print_cell(shape ? std::vector<Score>{scores[*shape]} : scores);
    }
    std::printf("\n");
  }
  std::fflush(stdout);
}

/// Fills a row without and a row with preparing.
void measure(std::size_t points, Row& raw, Row& with) {
  for (const Shape& shape : kShapes) {
    const double spacing = spacing_of(shape.points(points, 11, 0), 1);
    const PointCloud cloud = noisy(shape, points, raw.noise * spacing, raw.outliers);
    Context context;
    const auto clean = prepared(cloud, raw.noise, context);
    for (std::size_t m = 0; m < methods().size(); ++m) {
      raw.of_method[m].push_back(score_of(methods()[m], cloud, shape, spacing));
      with.of_method[m].push_back(clean ? score_of(methods()[m], *clean, shape, spacing) : Score{.failed = true});
    }
  }
}

void study(std::size_t points) {
  std::vector<Row> rows;
  for (const Shape& shape : kShapes) {
    std::printf("%s: %zu points, spacing %.4f\n", shape.name, points, spacing_of(shape.points(points, 11, 0), 1));
  }
  for (const double outliers : {0.0, 0.05, 0.2}) {
    for (const double noise : {0.1, 0.5, 1.0, 2.0, 5.0}) {
      std::vector<Row> pair(2, {.noise = noise, .outliers = outliers, .of_method = {}});
      for (Row& row : pair) row.of_method.resize(methods().size());
      pair[1].prepared = true;
      measure(points, pair[0], pair[1]);
      rows.insert(rows.end(), pair.begin(), pair.end());
      std::fprintf(stderr, "noise %.1f, %.0f %% outliers\n", noise, 100 * outliers);
    }
  }
  print_table(rows, std::nullopt);
  for (std::size_t shape = 0; shape < kShapes.size(); ++shape) print_table(rows, shape);
}

}  // namespace
}  // namespace surfaced

int main(int argc, char** argv) { surfaced::study(argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 4'000); }
