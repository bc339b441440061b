// SPDX-License-Identifier: GPL-3.0-or-later
// intrinsic-delaunay, from points in memory to a mesh in memory, and its certificate, beside CGAL's Delaunay
// triangulation: on scans and evenly sampled surfaces.
//   ./dev bench intrinsic_delaunay
// `delaunays` and `bytes_per_point` as in local_delaunay_benchmark.cpp.
#include "benchmarks/method_benchmarks.hpp"
#include "intrinsic_delaunay/intrinsic_delaunay.hpp"

namespace surfaced::benchmarks {
namespace {

void run_intrinsic_delaunay(benchmark::State& state, const std::string& name, unsigned threads) {
  measure(state, name, [&](RawCloud raw) {
    const PointCloud cloud = *make_cloud(std::move(raw), threads);
    Context context(threads);
    benchmark::DoNotOptimize(intrinsic_delaunay(cloud, {}, context)->mesh.triangles.size());
  });
}

void run_certify(benchmark::State& state, const std::string& name, unsigned threads) {
  Context context(threads);
  const auto result = intrinsic_delaunay(*make_cloud(raw_named(name), threads), {}, context);
  measure(state, name,
          [&](const RawCloud&) { benchmark::DoNotOptimize(certify(result->mesh, context)->largest_curvature); });
}

void add(const std::string& name, int runs, bool certificate) {
  add_one("intrinsic_delaunay_1_thread", name, runs, run_intrinsic_delaunay, name, 1U);
  add_one("intrinsic_delaunay_2_threads", name, runs, run_intrinsic_delaunay, name, 2U);
  if (certificate) add_one("certify_2_threads", name, runs, run_certify, name, 2U);
  add_one("cgal_delaunay", name, 1, run_delaunay, name);
}

}  // namespace
}  // namespace surfaced::benchmarks

int main(int argc, char** argv) {
  constexpr int kRuns = 3;
  for (const std::string scan : {"bunny", "igea", "anchor"}) {
    if (surfaced::benchmarks::have_scan(scan)) surfaced::benchmarks::add(scan, kRuns, true);
  }
  surfaced::benchmarks::add("bumpy1000000", kRuns, true);
  surfaced::benchmarks::add("torus1000000", kRuns, false);
  surfaced::benchmarks::add("bumpy10000000", 1, false);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
