// The table of docs/noise.md: how far from the truth each method ends on noisy tori, with and without preparing.
//   build/release/noise_study [POINTS]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "preparing/preparing.hpp"
#include "reconstruction/reconstruction.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

double distance_to_torus(const Point3& p) { return std::abs(std::hypot(std::hypot(p[0], p[1]) - 1, p[2]) - 0.3); }

/// Noise by a normal distribution along the normals; outliers evenly in a box around.
PointCloud noisy_torus(std::size_t points, double noise, double outliers) {
  std::vector<Point3> all = testing::random_torus(points, 11, noise);
  for (const Point3& p :
       testing::random_points(static_cast<std::size_t>(std::lround(outliers * static_cast<double>(points))), 12)) {
    all.push_back({1.5 * p[0], 1.5 * p[1], 0.5 * p[2]});
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
  double mean = 0;
  double covered = 0;
};

Score score_of(const TriangleMesh& mesh, double spacing) {
  constexpr double kNear = 2;
  const std::vector<Point3> samples = samples_of(mesh, spacing);
  if (samples.empty()) return {};
  Score score;
  for (const Point3& p : samples) score.mean += distance_to_torus(p) / static_cast<double>(samples.size());
  score.mean /= spacing;
  const std::vector<Point3> truth = testing::random_torus(4000, 77);
  for (const double d : nearest_points(samples, truth, 1).distance) {
    if (d < kNear * spacing) score.covered += 1.0 / static_cast<double>(truth.size());
  }
  return score;
}

void print_cell(const MethodInfo& method, const PointCloud& cloud, double spacing) {
  Context context(2);
  const auto mesh = run(cloud, method, *check_parameters(method, Json::object()), context);
  if (!mesh) {
    std::printf(" failed |");
    return;
  }
  const Score score = score_of(mesh->mesh, spacing);
  std::printf(" %.2f", score.mean);
  if (score.covered < 0.95) std::printf(" (%.0f %%)", 100 * score.covered);
  std::printf("%s |", topology_of(mesh->mesh).closed ? " c" : "");
}

void print_row(std::size_t points, double spacing, double noise, double outliers) {
  const PointCloud cloud = noisy_torus(points, noise * spacing, outliers);
  Context context;
  const auto clean = prepared(cloud, noise, context);
  for (const bool with : {false, true}) {
    if (with && !clean) continue;
    std::printf("| %.1f | %.0f %% | %s |", noise, 100 * outliers, with ? "yes" : "no");
    for (const MethodInfo& method : methods()) print_cell(method, with ? *clean : cloud, spacing);
    std::printf("\n");
    std::fflush(stdout);
  }
}

/// All rows, with the table's head.
void study(std::size_t points) {
  const double spacing = spacing_of(testing::random_torus(points, 11), 1);
  std::printf("%zu points, spacing %.4f\n\n| noise | outliers | prepared |", points, spacing);
  for (const MethodInfo& method : methods()) std::printf(" %s |", method.id.c_str());
  std::printf("\n|---|---|---|");
  for (std::size_t i = 0; i < methods().size(); ++i) std::printf("---|");
  std::printf("\n");
  for (const double outliers : {0.0, 0.05, 0.2}) {
    for (const double noise : {0.1, 0.5, 1.0, 2.0, 5.0}) print_row(points, spacing, noise, outliers);
  }
}

}  // namespace
}  // namespace surfaced

int main(int argc, char** argv) { surfaced::study(argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 10'000); }
