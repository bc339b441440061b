// minimum-boundary against CGAL's Delaunay triangulation (the unit of its speed) and advancing front, in one
// run on the same random points of a torus. Arguments: points, threads. `./dev bench minimum_boundary`.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <benchmark/benchmark.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "baselines/baselines.hpp"
#include "delaunay/delaunay.hpp"
#include "minimum_boundary/minimum_boundary.hpp"

namespace surfaced {
namespace {

const PointCloud& torus(std::size_t points) {
  static std::map<std::size_t, PointCloud> clouds;
  const auto [found, added] = clouds.try_emplace(points);
  if (added) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
    RawCloud raw;
    for (std::size_t i = 0; i < points; ++i) {
      const double u = angle(random);
      const double v = angle(random);
      raw.positions.push_back(
          {(1 + 0.3 * std::cos(v)) * std::cos(u), (1 + 0.3 * std::cos(v)) * std::sin(u), 0.3 * std::sin(v)});
    }
    found->second = *make_cloud(std::move(raw));
  }
  return found->second;
}

void count_points(benchmark::State& state) {
  state.SetItemsProcessed(state.iterations() * state.range(0));
  state.SetComplexityN(state.range(0));
}

/// CGAL's triangulation as its users call it: range insertion with its own spatial sorting.
void cgal_delaunay(benchmark::State& state) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  std::vector<Kernel::Point_3> points;
  for (const Point3& p : torus(static_cast<std::size_t>(state.range(0))).positions)
    points.emplace_back(p[0], p[1], p[2]);
  for (auto _ : state) {
    const CGAL::Delaunay_triangulation_3<Kernel> triangulation(points.begin(), points.end());
    benchmark::DoNotOptimize(triangulation.number_of_vertices());
  }
  count_points(state);
}

void complex_of_the_same_points(benchmark::State& state) {
  const PointCloud& cloud = torus(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    Context context(static_cast<unsigned>(state.range(1)));
    benchmark::DoNotOptimize(delaunay_complex(cloud, context, 1).ok());
  }
  count_points(state);
}

void reconstruct(benchmark::State& state, MinimumBoundaryParameters::Variant variant) {
  const PointCloud& cloud = torus(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    Context context(static_cast<unsigned>(state.range(1)));
    const auto result = minimum_boundary(cloud, {.variant = variant}, context);
    if (!result) state.SkipWithError(result.error().detail.c_str());
  }
  count_points(state);
}
void minimum_boundary_fast(benchmark::State& state) { reconstruct(state, MinimumBoundaryParameters::Variant::fast); }
void minimum_boundary_best(benchmark::State& state) { reconstruct(state, MinimumBoundaryParameters::Variant::best); }

void cgal_advancing_front(benchmark::State& state) {
  const PointCloud& cloud = torus(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    Context context;
    benchmark::DoNotOptimize(advancing_front(cloud, {}, context).ok());
  }
  count_points(state);
}

constexpr std::int64_t kSmall = 10'000;
constexpr std::int64_t kMiddle = 100'000;
constexpr std::int64_t kLarge = 1'000'000;

BENCHMARK(cgal_delaunay)
    ->Args({kSmall, 1})
    ->Args({kMiddle, 1})
    ->Args({kLarge, 1})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Complexity();
BENCHMARK(complex_of_the_same_points)
    ->ArgsProduct({{kSmall, kMiddle, kLarge}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(minimum_boundary_fast)
    ->ArgsProduct({{kSmall, kMiddle, kLarge}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(minimum_boundary_best)
    ->ArgsProduct({{kSmall, kMiddle, kLarge}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(cgal_advancing_front)->Args({kSmall, 1})->Args({kMiddle, 1})->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace surfaced

BENCHMARK_MAIN();
