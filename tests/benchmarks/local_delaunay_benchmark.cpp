// SPDX-License-Identifier: GPL-3.0-or-later
// local-delaunay, from points in memory to a mesh in memory, beside CGAL's Delaunay triangulation and advancing front,
// and its neighbour search beside nanoflann: on the scans of ./dev data (where present), a bumpy sphere and a torus
// sampled evenly; in the order of the file and shuffled.
//   ./dev bench local_delaunay
// `delaunays` is the best time in serial Delaunay triangulations by CGAL of the same points in the same order and run,
// `bytes_per_point` the peak of what was allocated beyond the points given. A Delaunay triangulation of 10 million
// points takes minutes, so there times are for comparison by `us_per_point`.
#include <nanoflann.hpp>

#include "baselines/baselines.hpp"
#include "benchmarks/method_benchmarks.hpp"
#include "local_delaunay/local_delaunay.hpp"
#include "spatial/spatial.hpp"

namespace surfaced::benchmarks {
namespace {

void run_with(benchmark::State& state, const std::string& name, unsigned threads,
              const LocalDelaunayParameters& parameters) {
  measure(state, name, [&](RawCloud raw) {
    const PointCloud cloud = *make_cloud(std::move(raw), threads);
    Context context(threads);
    benchmark::DoNotOptimize(local_delaunay(cloud, parameters, context)->mesh.triangles.size());
  });
}

void run_local_delaunay(benchmark::State& state, const std::string& name, unsigned threads) {
  run_with(state, name, threads, {});
}

void run_max_edge(benchmark::State& state, const std::string& name, unsigned threads) {
  run_with(state, name, threads, {.max_edge = 3});
}

void run_make_cloud(benchmark::State& state, const std::string& name, unsigned threads) {
  measure(state, name,
          [&](RawCloud raw) { benchmark::DoNotOptimize(make_cloud(std::move(raw), threads)->positions.data()); });
}

void run_advancing_front(benchmark::State& state, const std::string& name) {
  measure(state, name, [](RawCloud raw) {
    const PointCloud cloud = *make_cloud(std::move(raw));
    Context context;
    benchmark::DoNotOptimize(advancing_front(cloud, {}, context)->triangles.size());
  });
}

constexpr std::size_t kNeighbours = 16;

/// The cloud's own order is there already for the method, and no part of this.
void run_neighbours(benchmark::State& state, const std::string& name) {
  const PointCloud cloud = *make_cloud(raw_named(name));
  measure(state, name, [&](const RawCloud&) {
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
  // The same order as above, the best there is for the tree's caches.
  const PointCloud cloud = *make_cloud(raw_named(name));
  measure(state, name, [&](const RawCloud&) {
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

void add(const std::string& name, bool peers, int runs) {
  add_one("local_delaunay_1_thread", name, runs, run_local_delaunay, name, 1U);
  add_one("local_delaunay_2_threads", name, runs, run_local_delaunay, name, 2U);
  add_one("max_edge_3_1_thread", name, runs, run_max_edge, name, 1U);
  add_one("make_cloud_1_thread", name, runs, run_make_cloud, name, 1U);
  add_one("cgal_delaunay", name, 1, run_delaunay, name);
  if (!peers) return;
  add_one("cgal_advancing_front", name, 1, run_advancing_front, name);
  add_one("neighbours_16", name, runs, run_neighbours, name);
  add_one("nanoflann_16", name, runs, run_nanoflann, name);
}

}  // namespace
}  // namespace surfaced::benchmarks

int main(int argc, char** argv) {
  using surfaced::benchmarks::add;
  constexpr int kRuns = 3;
  for (const std::string scan : {"bunny", "igea", "anchor"}) {
    if (!surfaced::benchmarks::have_scan(scan)) continue;
    add(scan, true, kRuns);
    add(scan + "_shuffled", false, kRuns);
  }
  add("bumpy1000000", true, kRuns);
  add("bumpy1000000_shuffled", false, kRuns);
  add("torus1000000", true, kRuns);
  add("bumpy10000000", false, 1);
  add("bumpy10000000_shuffled", false, 1);
  add("torus10000000", false, 1);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
