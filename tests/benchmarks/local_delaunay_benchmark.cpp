// local-delaunay beside CGAL's Delaunay triangulation and advancing front, and its neighbour search beside nanoflann,
// on the scans of ../shared/data (where present) and on uniformly sampled tori.
//   ./dev bench local_delaunay
// `delaunays` is the time in serial Delaunay triangulations by CGAL of the same cloud in the same run,
// `bytes_per_point` the peak of what was allocated beyond the cloud.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nanoflann.hpp>
#include <new>
#include <numbers>
#include <random>

#include "baselines/baselines.hpp"
#include "io/io.hpp"
#include "local_delaunay/local_delaunay.hpp"
#include "spatial/spatial.hpp"

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

/// Points of a torus, evenly by area, rounded to float32 as in files.
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
    const auto rounded = [](double x) { return static_cast<double>(static_cast<float>(x)); };
    raw.positions.push_back({rounded(r * std::cos(u)), rounded(r * std::sin(u)), rounded(kTube * std::sin(v))});
  }
  return raw;
}

/// A cloud by name: a scan, or torus followed by the number of points.
const PointCloud& cloud_named(const std::string& name) {
  static std::map<std::string, PointCloud> clouds;
  const auto [known, is_new] = clouds.try_emplace(name);
  if (!is_new) return known->second;
  const bool torus = name.starts_with("torus");
  RawCloud raw = torus ? even_torus(std::stoul(name.substr(5)))
                       : *read_cloud(std::filesystem::path(SURFACED_SHARED_DATA) / (name + ".ply"));
  return known->second = *make_cloud(std::move(raw));
}

std::vector<Kernel::Point_3> exact_points(const PointCloud& cloud) {
  std::vector<Kernel::Point_3> points;
  for (const Point3& p : cloud.positions) points.emplace_back(p[0], p[1], p[2]);
  return points;
}

double seconds_of_delaunay(const std::string& name) {
  static std::map<std::string, double> known;
  const auto [entry, is_new] = known.try_emplace(name, 0);
  if (!is_new) return entry->second;
  const auto points = exact_points(cloud_named(name));
  double best = 1e300;
  for (int run = 0; run < 3; ++run) {
    const auto begin = Clock::now();
    const CGAL::Delaunay_triangulation_3<Kernel> triangulation(points.begin(), points.end());
    benchmark::DoNotOptimize(triangulation.number_of_cells());
    best = std::min(best, std::chrono::duration<double>(Clock::now() - begin).count());
  }
  return entry->second = best;
}

/// Runs the body, with what it took and allocated as counters.
template <class Body>
void measure(benchmark::State& state, const std::string& name, Body&& body) {
  const PointCloud& cloud = cloud_named(name);
  const double unit = seconds_of_delaunay(name);
  double best = 1e300;
  std::int64_t bytes = 0;
  for (auto _ : state) {
    const std::int64_t before = live_bytes;
    peak_bytes = before;
    const auto begin = Clock::now();
    body(cloud);
    best = std::min(best, std::chrono::duration<double>(Clock::now() - begin).count());
    bytes = std::max(bytes, peak_bytes - before);
  }
  const auto n = static_cast<double>(cloud.size());
  state.counters["points"] = n;
  state.counters["us_per_point"] = best / n * 1e6;
  state.counters["delaunays"] = best / unit;
  state.counters["bytes_per_point"] = static_cast<double>(bytes) / n;
  state.SetComplexityN(static_cast<benchmark::IterationCount>(cloud.size()));
}

void run_local_delaunay(benchmark::State& state, const std::string& name, unsigned threads) {
  measure(state, name, [&](const PointCloud& cloud) {
    Context context(threads);
    benchmark::DoNotOptimize(local_delaunay(cloud, {}, context)->mesh.triangles.size());
  });
}

void run_advancing_front(benchmark::State& state, const std::string& name) {
  measure(state, name, [](const PointCloud& cloud) {
    Context context;
    benchmark::DoNotOptimize(advancing_front(cloud, {}, context)->triangles.size());
  });
}

void run_delaunay(benchmark::State& state, const std::string& name) {
  measure(state, name, [](const PointCloud& cloud) {
    const auto points = exact_points(cloud);
    const CGAL::Delaunay_triangulation_3<Kernel> triangulation(points.begin(), points.end());
    benchmark::DoNotOptimize(triangulation.number_of_cells());
  });
}

constexpr std::size_t kNeighbours = 16;

void run_neighbours(benchmark::State& state, const std::string& name) {
  measure(state, name, [](const PointCloud& cloud) {
    const BoxTree tree(cloud.positions, 1);
    NeighbourSearch search(tree);
    Neighbours found;
    for (std::size_t leaf = 0; leaf < tree.leaves(); ++leaf) {
      search.begin_leaf(leaf, kNeighbours);
      for (std::size_t v = tree.first_point(leaf); v < tree.first_point(leaf + 1); ++v) {
        search.nearest(v, kNeighbours, found);
        benchmark::DoNotOptimize(found.covered2);
      }
    }
  });
}

/// The form in which nanoflann reads points.
struct NanoflannPoints {
  const std::vector<Point3>& positions;
  std::size_t kdtree_get_point_count() const { return positions.size(); }
  double kdtree_get_pt(std::size_t v, std::size_t axis) const { return positions[v][axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

void run_nanoflann(benchmark::State& state, const std::string& name) {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, NanoflannPoints>,
                                                   NanoflannPoints, 3, std::uint32_t>;
  measure(state, name, [](const PointCloud& cloud) {
    const NanoflannPoints points{cloud.positions};
    Tree tree(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    tree.buildIndex();
    std::array<std::uint32_t, kNeighbours + 1> index{};
    std::array<double, kNeighbours + 1> distance2{};
    for (const Point3& p : cloud.positions) {
      tree.knnSearch(p.data(), kNeighbours + 1, index.data(), distance2.data());
      benchmark::DoNotOptimize(distance2);
    }
  });
}

void add(const std::string& name, bool peers) {
  const auto finish = [](benchmark::internal::Benchmark* b) {
    b->Unit(benchmark::kMillisecond)->Iterations(3)->UseRealTime();
  };
  const auto add_one = [&](const std::string& what, auto function, auto... arguments) {
    finish(benchmark::RegisterBenchmark((what + "/" + name).c_str(), function, name, arguments...));
  };
  add_one("local_delaunay_1_thread", run_local_delaunay, 1U);
  add_one("local_delaunay_2_threads", run_local_delaunay, 2U);
  add_one("cgal_delaunay", run_delaunay);
  if (!peers) return;
  add_one("cgal_advancing_front", run_advancing_front);
  add_one("neighbours_16", run_neighbours);
  add_one("nanoflann_16", run_nanoflann);
}

}  // namespace
}  // namespace surfaced::benchmarks

int main(int argc, char** argv) {
  for (const char* scan : {"bunny", "igea", "anchor"}) {
    if (std::filesystem::exists(std::filesystem::path(SURFACED_SHARED_DATA) / (std::string(scan) + ".ply")))
      surfaced::benchmarks::add(scan, true);
  }
  surfaced::benchmarks::add("torus1000000", true);
  surfaced::benchmarks::add("torus10000000", false);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
