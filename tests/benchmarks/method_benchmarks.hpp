// SPDX-License-Identifier: GPL-3.0-or-later
// What the benchmarks of the methods that grow a front share: clouds, counters, and the unit, a Delaunay triangulation.
#pragma once

#include <benchmark/benchmark.h>

#include <functional>
#include <string>

#include "cloud/cloud.hpp"

namespace surfaced::benchmarks {

/// Whether SURFACED_TEST_DATA has the scan.
bool have_scan(const std::string& name);

/// A cloud by name: a scan, or torus or bumpy followed by the number of points; then perhaps _shuffled. Keeps one
/// only: benchmarks of a cloud follow one another.
const RawCloud& raw_named(const std::string& name);

/// Runs the body on a copy of the points, with what it took and allocated as counters.
void measure(benchmark::State& state, const std::string& name, const std::function<void(RawCloud)>& body);

/// The unit itself, measured like the others.
void run_delaunay(benchmark::State& state, const std::string& name);

template <class... Arguments>
void add_one(const std::string& what, const std::string& name, int runs, Arguments... arguments) {
  benchmark::RegisterBenchmark((what + "/" + name).c_str(), arguments...)
      ->Unit(benchmark::kMillisecond)
      ->Iterations(runs)
      ->UseManualTime();
}

}  // namespace surfaced::benchmarks
