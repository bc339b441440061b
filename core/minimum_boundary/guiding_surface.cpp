// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/guiding_surface.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/parallel.hpp"
#include "base/union_find.hpp"
#include "front/local_stars.hpp"
#include "local_delaunay/local_delaunay.hpp"
#include "spatial/spatial.hpp"

namespace surfaced::boundary {
namespace {

/// Neighbours that a point is moved with.
constexpr std::size_t kSmoothingNeighbours = 12;
/// Points nearer than this share of the distance to the 24th nearest neighbour repeat each other.
constexpr double kRepeat = 0.05;
constexpr std::size_t kNeighbourhood = 24;
/// Fewer points have no neighbourhood to be smoothed in.
constexpr std::size_t kFewestSmoothed = 2 * kSmoothingNeighbours;

/// Every point moved along its normal onto the plane through the mean of its neighbours and itself.
Result<std::vector<Point3>> onto_planes(const std::vector<Point3>& positions, Context& context) {
  const BoxTree tree(positions, context.threads());
  const Result<front::LocalStars> stars = front::local_stars(tree, {.neighbours = kSmoothingNeighbours}, context);
  if (!stars) return stars.error();
  std::vector<Point3> moved(positions);
  parallel_tasks(context.threads(), tree.blocks(), [&](std::size_t block) {
    NeighbourSearch search(tree);
    Neighbours near;
    for (std::size_t leaf = tree.first_leaf(block); leaf < tree.first_leaf(block + 1); ++leaf) {
      search.begin_leaf(leaf, kSmoothingNeighbours);
      for (std::size_t v = tree.first_point(leaf); v < tree.first_point(leaf + 1); ++v) {
        search.nearest(v, kSmoothingNeighbours, near);
        Point3 mean{};
        for (std::size_t k = 0; k < near.count; ++k) {
          mean = {mean[0] + near.x[k], mean[1] + near.y[k], mean[2] + near.z[k]};
        }
        const Normal3& f = stars->normals[v];
        const Point3 n{static_cast<double>(f[0]), static_cast<double>(f[1]), static_cast<double>(f[2])};
        const double off = dot(n, mean) / static_cast<double>(near.count + 1) / tree.scale();
        for (std::size_t i = 0; i < 3; ++i) moved[v][i] += off * n[i];
      }
    }
  });
  return moved;
}

/// Median distance to the 24th nearest neighbour, or the farthest of fewer.
double neighbourhood_of(const std::vector<Point3>& positions, unsigned threads) {
  const BoxTree tree(positions, threads);
  std::vector<double> reach(positions.size());
  parallel_tasks(threads, tree.blocks(), [&](std::size_t block) {
    NeighbourSearch search(tree);
    Neighbours near;
    for (std::size_t leaf = tree.first_leaf(block); leaf < tree.first_leaf(block + 1); ++leaf) {
      search.begin_leaf(leaf, kNeighbourhood);
      for (std::size_t v = tree.first_point(leaf); v < tree.first_point(leaf + 1); ++v) {
        search.nearest(v, kNeighbourhood, near);
        double farthest = 0;
        for (std::size_t k = 0; k < near.count; ++k) farthest = std::max(farthest, near.distance2[k]);
        reach[v] = std::sqrt(farthest) / tree.scale();
      }
    }
  });
  const auto middle = reach.begin() + static_cast<std::ptrdiff_t>(reach.size() / 2);
  std::ranges::nth_element(reach, middle);
  return *middle;
}

enum class Side : std::uint8_t { unknown, in, out };

/// The side of the complex whose facet has these vertices; invalid if there is none.
SideIndex side_of(const DelaunayComplex& complex, const Triangle& t) {
  VertexIndex fewest = t[0];
  for (const VertexIndex v : t) {
    if (complex.star(v).size() < complex.star(fewest).size()) fewest = v;
  }
  Triangle sorted = t;
  std::ranges::sort(sorted);
  for (const SideIndex corner : complex.star(fewest)) {
    const auto& vertices = complex.table[corner / 4].vertices;
    if (!std::ranges::includes(vertices, sorted)) continue;
    for (std::size_t i = 0; i < 4; ++i) {
      if (!std::ranges::binary_search(sorted, vertices[i])) return SideIndex(corner / 4 * 4 + i);
    }
  }
  return {};
}

bool same_turn(const Triangle& a, const Triangle& b) {
  const auto first = std::ranges::find(b, a[0]) - b.begin();
  return b[static_cast<std::size_t>(first + 1) % 3] == a[1];
}

/// What the guide says of the cells, and which facets are its triangles.
struct Seeds {
  std::vector<Side> sides;
  /// Bit i: side i of the cell is a triangle of the guide.
  std::vector<std::uint8_t> walls;
};

Seeds seeds_of(const DelaunayComplex& complex, const GuidingSurface& guide) {
  Seeds seeds;
  seeds.sides.assign(complex.cells(), Side::unknown);
  seeds.walls.assign(complex.cells(), 0);
  std::vector<int> votes(complex.cells(), 0);
  for (const Triangle& t : guide.triangles) {
    const SideIndex side = side_of(complex, t);
    if (!side.valid()) continue;
    const SideIndex mate = complex.mate(side);
    seeds.walls[side / 4] |= static_cast<std::uint8_t>(1U << (side % 4));
    seeds.walls[mate / 4] |= static_cast<std::uint8_t>(1U << (mate % 4));
    const int inner = same_turn(t, complex.outward_facet(side)) ? 1 : -1;
    votes[side / 4] += inner;
    votes[mate / 4] -= inner;
  }
  for (std::size_t c = 0; c < votes.size(); ++c) {
    if (complex.infinite(CellIndex(c)) || votes[c] < 0) {
      seeds.sides[c] = Side::out;
    } else if (votes[c] > 0) {
      seeds.sides[c] = Side::in;
    }
  }
  return seeds;
}

class Spreading {
 public:
  Spreading(const DelaunayComplex& complex, Seeds seeds)
      : complex_(complex), sets_(complex.cells()), seeds_(std::move(seeds)) {}

  void cross(SideIndex side) {
    if ((unsigned{seeds_.walls[side / 4]} >> (side % 4) & 1U) != 0) return;
    const std::uint32_t a = sets_.find(side / 4);
    const std::uint32_t b = sets_.find(complex_.neighbour(side));
    if (a == b || (seeds_.sides[a] != Side::unknown && seeds_.sides[b] != Side::unknown)) return;
    const Side side_of_both = std::max(seeds_.sides[a], seeds_.sides[b]);
    sets_.unite(a, b);
    seeds_.sides[sets_.find(a)] = side_of_both;
  }

  std::vector<std::uint8_t> labels() {
    std::vector<std::uint8_t> in(complex_.cells());
    for (std::size_t c = 0; c < in.size(); ++c) in[c] = seeds_.sides[sets_.find(c)] == Side::out ? 0 : 1;
    return in;
  }

 private:
  const DelaunayComplex& complex_;
  UnionFind sets_;
  /// The side of a set is that of its least cell.
  Seeds seeds_;
};

std::size_t unused_points(std::size_t points, const std::vector<Triangle>& triangles) {
  std::vector<bool> used(points, false);
  for (const Triangle& t : triangles) {
    for (const VertexIndex v : t) used[v] = true;
  }
  return static_cast<std::size_t>(std::ranges::count(used, false));
}

}  // namespace

Result<GuidingSurface> guiding_surface(std::vector<Point3> positions, unsigned smoothing_rounds, const Context& context,
                                       unsigned threads) {
  // A part of the work without stages of its own: it stops with this one and reports nothing.
  std::atomic<bool> stop{context.cancelled()};
  Context own(
      threads, [&](double, std::string_view) { stop = stop || context.cancelled(); }, &stop);
  PointCloud points{std::move(positions), {}, {}, {}, {}};
  if (points.size() >= kFewestSmoothed) {
    for (unsigned round = 0; round < smoothing_rounds; ++round) {
      Result<std::vector<Point3>> moved = onto_planes(points.positions, own);
      if (!moved) return std::move(moved).error();
      points.positions = std::move(*moved);
    }
  }
  Result<LocalDelaunayResult> surface = local_delaunay(points, {}, own);
  if (surface) {
    const std::size_t unused = unused_points(points.size(), surface->mesh.triangles);
    return GuidingSurface{std::move(points.positions), std::move(surface->mesh.triangles),
                          surface->statistics.open_edges, unused};
  }
  const ErrorCode code = surface.error().code;
  if (code == ErrorCode::too_few_points || code == ErrorCode::collinear) return GuidingSurface{};
  return std::move(surface).error();
}

std::vector<Point3> without_repeats(const DelaunayComplex& complex, unsigned threads) {
  const double near = kRepeat * neighbourhood_of(complex.positions, threads);
  UnionFind groups(complex.points());
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    if (complex.infinite(CellIndex(c))) continue;
    for (const auto& [i, j] : kCellEdges) {
      const VertexIndex a = complex.vertex(4 * c + i);
      const VertexIndex b = complex.vertex(4 * c + j);
      if (norm(complex.positions[a] - complex.positions[b]) <= near) groups.unite(a, b);
    }
  }
  std::vector<Point3> kept;
  for (std::size_t v = 0; v < complex.points(); ++v) {
    if (groups.find(v) == v) kept.push_back(complex.positions[v]);
  }
  return kept;
}

std::vector<std::uint8_t> guided_labels(const DelaunayComplex& complex, const RatedFacets& rated,
                                        const GuidingSurface& guide) {
  Spreading spreading(complex, seeds_of(complex, guide));
  for (const FacetRatings::Passage& passage : rated.passages) spreading.cross(passage.side);
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (s < complex.mate(s)) spreading.cross(SideIndex(s));
  }
  return spreading.labels();
}

}  // namespace surfaced::boundary
