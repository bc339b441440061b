// SPDX-License-Identifier: GPL-3.0-or-later
#include "benchmarks/method_benchmarks.hpp"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <new>
#include <numbers>
#include <random>

#include "io/io.hpp"

namespace {

std::atomic<std::int64_t> live_bytes{0};
std::atomic<std::int64_t> peak_bytes{0};

void count(std::int64_t bytes) {
  const std::int64_t now = live_bytes += bytes;
  std::int64_t peak = peak_bytes.load();
  while (now > peak && !peak_bytes.compare_exchange_weak(peak, now)) {
  }
}

void* counted(void* p) {
  if (p == nullptr) throw std::bad_alloc();
  count(static_cast<std::int64_t>(malloc_usable_size(p)));
  return p;
}

void release(void* p) {
  if (p != nullptr) count(-static_cast<std::int64_t>(malloc_usable_size(p)));
  std::free(p);
}

}  // namespace

void* operator new(std::size_t size) { return counted(std::malloc(size)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto a = static_cast<std::size_t>(alignment);
  return counted(std::aligned_alloc(a, (size + a - 1) / a * a));
}
void operator delete(void* p) noexcept { release(p); }
void operator delete(void* p, std::size_t) noexcept { release(p); }
void operator delete(void* p, std::align_val_t) noexcept { release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { release(p); }

namespace surfaced::benchmarks {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Clock = std::chrono::steady_clock;

double rounded(double x) { return static_cast<double>(static_cast<float>(x)); }

/// Points of a torus, evenly by area, in random order, rounded to float32 as in files.
RawCloud even_torus(std::size_t n) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
  std::uniform_real_distribution<double> share(0, 1);
  constexpr double kTube = 0.4;
  RawCloud raw;
  raw.positions.reserve(n);
  while (raw.positions.size() < n) {
    const double u = angle(random);
    const double v = angle(random);
    const double r = 1 + kTube * std::cos(v);
    if (share(random) * (1 + kTube) > r) continue;
    raw.positions.push_back({rounded(r * std::cos(u)), rounded(r * std::sin(u)), rounded(kTube * std::sin(v))});
  }
  return raw;
}

/// Points of a bumpy sphere along a jittered golden spiral: evenly spread, from pole to pole.
RawCloud bumpy_sphere(std::size_t n) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(-0.2, 0.2);
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  RawCloud raw;
  raw.positions.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double at = static_cast<double>(i) + 0.5 + jitter(random);
    const double z = 1 - 2 * at / static_cast<double>(n);
    const double ring = std::sqrt(std::max(0.0, 1 - z * z));
    const double x = ring * std::cos(turn * at);
    const double y = ring * std::sin(turn * at);
    const double r = 1 + 0.15 * std::sin(5 * x) * std::sin(4 * y) * std::sin(6 * z) +
                     0.02 * std::sin(40 * x) * std::sin(40 * y) * std::sin(40 * z);
    raw.positions.push_back({rounded(r * x), rounded(r * y), rounded(r * z)});
  }
  return raw;
}

constexpr std::string_view kShuffled = "_shuffled";

RawCloud make_raw(const std::string& name) {
  if (name.ends_with(kShuffled)) {
    RawCloud raw = make_raw(name.substr(0, name.size() - kShuffled.size()));
    std::ranges::shuffle(raw.positions, std::mt19937(2));
    return raw;
  }
  if (name.starts_with("torus")) return even_torus(std::stoul(name.substr(5)));
  if (name.starts_with("bumpy")) return bumpy_sphere(std::stoul(name.substr(5)));
  return *read_cloud(std::filesystem::path(SURFACED_SHARED_DATA) / (name + ".ply"));
}

std::vector<Kernel::Point_3> exact_points(const RawCloud& cloud) {
  std::vector<Kernel::Point_3> points;
  for (const Point3& p : cloud.positions) points.emplace_back(p[0], p[1], p[2]);
  return points;
}

double seconds_of_delaunay(const std::string& name) {
  static std::map<std::string, double> known;
  const auto [entry, is_new] = known.try_emplace(name, 0);
  if (!is_new) return entry->second;
  const auto points = exact_points(raw_named(name));
  double best = 1e300;
  for (int run = 0; run < 3; ++run) {
    const auto begin = Clock::now();
    const CGAL::Delaunay_triangulation_3<Kernel> triangulation(points.begin(), points.end());
    benchmark::DoNotOptimize(triangulation.number_of_cells());
    best = std::min(best, std::chrono::duration<double>(Clock::now() - begin).count());
  }
  return entry->second = best;
}

}  // namespace

bool have_scan(const std::string& name) {
  return std::filesystem::exists(std::filesystem::path(SURFACED_SHARED_DATA) / (name + ".ply"));
}

const RawCloud& raw_named(const std::string& name) {
  static std::pair<std::string, RawCloud> last;
  if (last.first != name) {
    last = {};
    last = {name, make_raw(name)};
  }
  return last.second;
}

constexpr std::size_t kLargestUnit = 2'000'000;

void measure(benchmark::State& state, const std::string& name, const std::function<void(RawCloud)>& body) {
  const RawCloud& points = raw_named(name);
  double best = 1e300;
  std::int64_t bytes = 0;
  for (auto _ : state) {
    RawCloud raw = points;
    const std::int64_t before = live_bytes;
    peak_bytes = before;
    const auto begin = Clock::now();
    body(std::move(raw));
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    state.SetIterationTime(seconds);
    best = std::min(best, seconds);
    bytes = std::max(bytes, peak_bytes - before);
  }
  const auto n = static_cast<double>(points.size());
  state.counters["us_per_point"] = best / n * 1e6;
  if (points.size() <= kLargestUnit) state.counters["delaunays"] = best / seconds_of_delaunay(name);
  state.counters["bytes_per_point"] = static_cast<double>(bytes) / n;
  state.SetComplexityN(static_cast<benchmark::IterationCount>(points.size()));
}

void run_delaunay(benchmark::State& state, const std::string& name) {
  measure(state, name, [](const RawCloud& raw) {
    const auto points = exact_points(raw);
    const CGAL::Delaunay_triangulation_3<Kernel> triangulation(points.begin(), points.end());
    benchmark::DoNotOptimize(triangulation.number_of_cells());
  });
}

}  // namespace surfaced::benchmarks
