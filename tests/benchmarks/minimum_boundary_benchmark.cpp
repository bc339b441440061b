// SPDX-License-Identifier: GPL-3.0-or-later
// minimum-boundary, from points in memory to a mesh in memory, beside CGAL's Delaunay triangulation, which is the unit
// of its speed, and CGAL's advancing front: on scans of ./dev data (where present), random points of a bumpy torus,
// which stands for free-form surfaces, and of an exact torus, the worst case: many points lie on common spheres.
//   ./dev bench minimum_boundary        build/release/minimum_boundary_benchmark --benchmark_filter=igea
// `delaunays` is the best time in serial triangulations by CGAL (range insertion with its own spatial sorting, the best
// of as many runs) of the same points in the same run, `us_per_point` that time, `bytes_per_point` the peak of resident
// memory beyond what was there before, and `growth` the time per point over that of a cloud of the same shape with a
// tenth of the points.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <string>

#include "baselines/baselines.hpp"
#include "delaunay/delaunay.hpp"
#include "io/io.hpp"
#include "minimum_boundary/minimum_boundary.hpp"

namespace surfaced::benchmarks {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kTenThousand = 10'000;
constexpr std::size_t kHundredThousand = 100'000;
constexpr std::size_t kMillion = 1'000'000;
constexpr int kRuns = 3;

/// Random points of a torus; `bumps` of 1 makes its tube swell and its circle wobble.
RawCloud torus(std::size_t points, double bumps) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
  RawCloud raw;
  raw.positions.reserve(points);
  for (std::size_t i = 0; i < points; ++i) {
    const double u = angle(random);
    const double v = angle(random);
    const double circle = 1 + bumps * 0.05 * std::sin(3 * u);
    const double tube =
        0.3 + bumps * (0.03 * std::sin(5 * u + 1) * std::cos(3 * v) + 0.02 * std::sin(7 * u) * std::sin(2 * v));
    raw.positions.push_back({(circle + tube * std::cos(v)) * std::cos(u), (circle + tube * std::cos(v)) * std::sin(u),
                             tube * std::sin(v) + bumps * 0.1 * std::sin(2 * u)});
  }
  return raw;
}

struct Input {
  std::string name;
  std::function<RawCloud()> make;
  /// The same shape with a tenth of the points, if there is one.
  std::string tenth;
  int runs = kRuns;
};

std::vector<Input> inputs() {
  std::vector<Input> all{
      {"bumpy-10k", [] { return torus(kTenThousand, 1); }, "", 2 * kRuns},
      {"bumpy-100k", [] { return torus(kHundredThousand, 1); }, "bumpy-10k"},
      {"bumpy-1M", [] { return torus(kMillion, 1); }, "bumpy-100k", 1},
      {"torus-100k", [] { return torus(kHundredThousand, 0); }, "", 1},
  };
  for (const char* name : {"bunny", "anchor", "igea"}) {
    const std::filesystem::path path = std::filesystem::path(SURFACED_SHARED_DATA) / (std::string(name) + ".ply");
    if (!std::filesystem::exists(path)) continue;
    all.push_back({name, [path] { return *read_cloud(path); }, ""});
  }
  return all;
}

const PointCloud& cloud_of(const Input& input) {
  // One at a time: a million points with their results need not stay for the next cloud.
  static std::string name;
  static PointCloud cloud;
  if (name != input.name) {
    cloud = *make_cloud(input.make());
    name = input.name;
  }
  return cloud;
}

/// A number of bytes in /proc/self/status, 0 where there is no such file.
double status_bytes(const std::string& field) {
  std::ifstream status("/proc/self/status");
  constexpr double kKilo = 1024;
  for (std::string word; status >> word;) {
    double value = 0;
    if (word == field + ":" && status >> value) return kKilo * value;
  }
  return 0;
}

/// What each measurement took per point, in seconds, by its name.
std::map<std::string, double> seconds_per_point;

/// Runs the task as often as the state asks and counts; `kind` names the task in all sizes.
void measure(benchmark::State& state, const Input& input, const std::string& kind, const std::function<void()>& task) {
  const auto points = static_cast<double>(cloud_of(input).size());
  double best = INFINITY;
  double peak = 0;
  for (auto _ : state) {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";
    const double before = status_bytes("VmRSS");
    const Clock::time_point start = Clock::now();
    task();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    state.SetIterationTime(seconds);
    best = std::min(best, seconds / points);
    peak = std::max(peak, status_bytes("VmHWM") - before);
  }
  seconds_per_point[input.name + kind] = best;
  constexpr double kMicro = 1e6;
  state.counters["us_per_point"] = kMicro * best;
  state.counters["bytes_per_point"] = peak / points;
  const auto found = [&](const std::string& name) {
    const auto at = seconds_per_point.find(name);
    return at != seconds_per_point.end() ? at->second : NAN;
  };
  state.counters["delaunays"] = best / found(input.name + "cgal_delaunay");
  if (!input.tenth.empty()) state.counters["growth"] = best / found(input.tenth + kind);
}

/// CGAL's triangulation as its users call it: range insertion with its own spatial sorting.
void cgal_delaunay(const PointCloud& cloud) {
  std::vector<Kernel::Point_3> points;
  for (const Point3& p : cloud.positions) points.emplace_back(p[0], p[1], p[2]);
  const CGAL::Delaunay_triangulation_3<Kernel> triangulation(points.begin(), points.end());
  benchmark::DoNotOptimize(triangulation.number_of_vertices());
}

void add(const Input& input, const std::string& kind, const std::function<void(const PointCloud&)>& task) {
  benchmark::RegisterBenchmark((input.name + "/" + kind).c_str(),
                               [=](benchmark::State& state) {
                                 const PointCloud& cloud = cloud_of(input);
                                 measure(state, input, kind, [&] { task(cloud); });
                               })
      ->Iterations(input.runs)
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

void add_all(const Input& input) {
  using Variant = MinimumBoundaryParameters::Variant;
  add(input, "cgal_delaunay", cgal_delaunay);
  const auto reconstruct = [](const PointCloud& cloud, Variant variant, unsigned threads) {
    Context context(threads);
    if (!minimum_boundary(cloud, {.variant = variant}, context)) std::abort();
  };
  for (const unsigned threads : {1U, 2U}) {
    const std::string suffix = "/threads:" + std::to_string(threads);
    add(input, "complex" + suffix, [=](const PointCloud& cloud) {
      Context context(threads);
      benchmark::DoNotOptimize(delaunay_complex(cloud, context, 1).ok());
    });
    add(input, "fast" + suffix, [=](const PointCloud& cloud) { reconstruct(cloud, Variant::fast, threads); });
  }
  add(input, "best/threads:2", [=](const PointCloud& cloud) { reconstruct(cloud, Variant::best, 2); });
  if (input.runs == 1) return;
  add(input, "cgal_advancing_front", [](const PointCloud& cloud) {
    Context context;
    benchmark::DoNotOptimize(advancing_front(cloud, {}, context).ok());
  });
}

}  // namespace
}  // namespace surfaced::benchmarks

int main(int argc, char** argv) {
  for (const auto& input : surfaced::benchmarks::inputs()) surfaced::benchmarks::add_all(input);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
