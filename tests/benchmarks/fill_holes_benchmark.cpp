// SPDX-License-Identifier: GPL-3.0-or-later
// Cost per added point: filling a hole, and upsampling. The rate `added` is points per second.
#include <benchmark/benchmark.h>

#include "hole_filling/hole_filling.hpp"
#include "intrinsic_delaunay/intrinsic_delaunay.hpp"
#include "intrinsic_delaunay/upsampling.hpp"
#include "support/holes.hpp"

namespace {

using namespace surfaced;

void fill_a_disc(benchmark::State& state, Rotation rotation) {
  const TriangleMesh whole = surfaced::testing::bumpy_sphere(7);  // 163,842 vertices
  const double radius = static_cast<double>(state.range(0)) / 100;
  const TriangleMesh open = surfaced::testing::cut_disc(whole, whole.positions[7], radius).rest;
  std::size_t added = 0;
  for (auto _ : state) {
    state.PauseTiming();
    TriangleMesh mesh = open;
    state.ResumeTiming();
    Context context;
    const auto report = fill_holes(mesh, {.holes = FillParameters::Holes::all, .rotation = rotation}, context);
    added = report ? report->vertices_added : 0;
    if (!report || report->filled != 1 || report->filled_by_library != 0) state.SkipWithError("not filled by angles");
  }
  state.counters["points"] = static_cast<double>(added);
  state.counters["added"] =
      benchmark::Counter(static_cast<double>(added), benchmark::Counter::kIsIterationInvariantRate);
  state.SetComplexityN(static_cast<benchmark::IterationCount>(added));
}
BENCHMARK_CAPTURE(fill_a_disc, normal, Rotation::normal)
    ->Arg(10)
    ->Arg(20)
    ->Arg(40)
    ->Arg(80)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();
BENCHMARK_CAPTURE(fill_a_disc, none, Rotation::none)->Arg(20)->Unit(benchmark::kMillisecond);

void upsample_a_sphere(benchmark::State& state, idt::Upsampling way) {
  RawCloud raw;
  raw.positions = surfaced::testing::sphere_points(static_cast<std::size_t>(state.range(0)));
  std::erase_if(raw.positions, [i = 0U](const Point3& p) mutable { return p[2] > 0 && ++i % 3 != 0; });
  const Result<PointCloud> cloud = make_cloud(raw);
  Context context;
  const auto reconstruct = [&](const PointCloud& points) -> Result<TriangleMesh> {
    Result<IntrinsicDelaunayResult> result = intrinsic_delaunay(points, {}, context);
    if (!result) return std::move(result).error();
    return std::move(result->mesh);
  };
  const Result<TriangleMesh> mesh = reconstruct(*cloud);
  const double spacing = std::sqrt(4 * std::numbers::pi / static_cast<double>(state.range(0)));
  std::size_t added = 0;
  for (auto _ : state) {
    const auto result = idt::upsample(*cloud, *mesh, spacing, way, reconstruct, context);
    added = result ? result->statistics.points_added : 0;
  }
  state.counters["points"] = static_cast<double>(added);
  state.counters["added"] =
      benchmark::Counter(static_cast<double>(added), benchmark::Counter::kIsIterationInvariantRate);
  state.SetComplexityN(static_cast<benchmark::IterationCount>(added));
}
BENCHMARK_CAPTURE(upsample_a_sphere, jet, idt::Upsampling::jet)
    ->Arg(10'000)
    ->Arg(40'000)
    ->Arg(160'000)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();
BENCHMARK_CAPTURE(upsample_a_sphere, paper, idt::Upsampling::paper)
    ->Arg(10'000)
    ->Arg(40'000)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();

}  // namespace

BENCHMARK_MAIN();
