// SPDX-License-Identifier: GPL-3.0-or-later
// Each step against its slow definition.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "minimum_boundary/boundary_complex.hpp"
#include "minimum_boundary/curvature.hpp"
#include "minimum_boundary/descent.hpp"
#include "minimum_boundary/hull.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/labelling.hpp"
#include "minimum_boundary/measures.hpp"
#include "minimum_boundary/min_cut.hpp"
#include "support/nasty_clouds.hpp"

namespace surfaced::boundary {
namespace {

struct Fixture {
  PointCloud cloud;
  DelaunayComplex complex;
};

/// Small clouds that are not flat.
std::vector<Fixture> fixtures(std::uint64_t first, std::uint64_t count) {
  std::vector<Fixture> list;
  for (std::uint64_t number = first; number < first + count; ++number) {
    Fixture f{*make_cloud(testing::raw_cloud(testing::NastyClouds::make(number).points)), {}};
    Context context;
    auto complex = delaunay_complex(f.cloud, context, 1);
    if (!complex) continue;
    f.complex = std::move(*complex);
    list.push_back(std::move(f));
  }
  return list;
}

Labelling random_labels(const DelaunayComplex& complex, std::mt19937& random) {
  std::vector<std::uint8_t> in(complex.cells());
  const auto share = 1 + random() % 9;
  for (std::size_t c = 0; c < in.size(); ++c) in[c] = !complex.infinite(CellIndex(c)) && random() % 10 < share ? 1 : 0;
  Labelling labels(complex);
  labels.assign(in, 1);
  return labels;
}

/// Counts umbrellas at a vertex from the triangles alone: the cycles of its link, and whether they touch.
VertexState state_by_umbrellas(const Labelling& labels, const TriangleMesh& mesh, VertexIndex v) {
  std::map<std::size_t, std::vector<std::size_t>> link;
  std::size_t edges = 0;
  for (const Triangle& t : mesh.triangles) {
    const auto at = std::ranges::find(t, v);
    if (at == t.end()) continue;
    const auto i = static_cast<std::size_t>(at - t.begin());
    link[t[(i + 1) % 3]].push_back(t[(i + 2) % 3]);
    link[t[(i + 2) % 3]].push_back(t[(i + 1) % 3]);
    ++edges;
  }
  if (edges == 0) {
    return labels.in(DelaunayComplex::cell_of(labels.complex().star(v)[0])) ? VertexState::interior
                                                                            : VertexState::outside;
  }
  std::set<std::size_t> reached;
  std::vector<std::size_t> stack{link.begin()->first};
  while (!stack.empty()) {
    const std::size_t u = stack.back();
    stack.pop_back();
    if (!reached.insert(u).second) continue;
    stack.insert(stack.end(), link[u].begin(), link[u].end());
  }
  const bool simple = std::ranges::all_of(link, [](const auto& entry) { return entry.second.size() == 2; });
  return simple && reached.size() == link.size() ? VertexState::surface : VertexState::pinched;
}

TEST(TheoremA, state_of_a_vertex_agrees_with_counting_umbrellas_on_random_labels) {
  std::mt19937 random(1);
  for (const Fixture& f : fixtures(0, 400)) {
    const Labelling labels = random_labels(f.complex, random);
    const TriangleMesh mesh = surface_of(labels, f.cloud);
    StarCounter counter(f.complex);
    for (std::size_t v = 0; v < f.complex.points(); ++v) {
      const VertexState expected = state_by_umbrellas(labels, mesh, VertexIndex(v));
      const VertexState state = labels.state(VertexIndex(v));
      ASSERT_EQ(state, expected);
      const StarGroups groups = counter.count(labels, VertexIndex(v));
      ASSERT_EQ(groups.in == 0, state == VertexState::outside);
      ASSERT_EQ(groups.out == 0, state == VertexState::interior);
      ASSERT_EQ(groups.in == 1 && groups.out == 1, state == VertexState::surface);
    }
  }
}

TEST(Labelling, flipping_cell_by_cell_equals_assigning_all_labels) {
  std::mt19937 random(2);
  for (const Fixture& f : fixtures(500, 60)) {
    const Labelling expected = random_labels(f.complex, random);
    Labelling labels(f.complex);
    for (std::size_t c = 0; c < f.complex.cells(); ++c) {
      if (expected.in(CellIndex(c))) labels.flip(CellIndex(c));
    }
    EXPECT_TRUE(labels == expected);
  }
}

/// Algorithm 1 as printed, every test made from scratch: O(F) per step.
std::set<std::array<VertexIndex, 3>> slow_boundary_complex(const DelaunayComplex& complex, bool connected) {
  using Facet = std::array<VertexIndex, 3>;
  const Criterion criterion(complex);
  std::vector<SideIndex> order;
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (s < complex.mate(s) && complex.facet(SideIndex(s))[2] < complex.points()) order.emplace_back(s);
  }
  std::ranges::sort(order, [&](SideIndex a, SideIndex b) { return criterion.less(a, b); });
  std::set<Facet> chosen;
  const auto edge_use = [&](VertexIndex a, VertexIndex b) {
    return std::ranges::count_if(
        chosen, [&](const Facet& f) { return std::ranges::count(f, a) > 0 && std::ranges::count(f, b) > 0; });
  };
  std::vector<std::size_t> tree(complex.points());
  std::iota(tree.begin(), tree.end(), 0U);
  std::set<VertexIndex> used;
  const auto wanted = [&](const Facet& f) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (edge_use(f[i], f[(i + 1) % 3]) == 1) return true;
    }
    if (!connected) return !(used.contains(f[0]) && used.contains(f[1]) && used.contains(f[2]));
    return tree[f[0]] != tree[f[1]] || tree[f[0]] != tree[f[2]];
  };
  const auto done = [&] {
    for (const Facet& f : chosen) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (edge_use(f[i], f[(i + 1) % 3]) == 1) return false;
      }
    }
    if (!connected) return used.size() == complex.points();
    return std::ranges::all_of(tree, [&](std::size_t t) { return t == tree[0]; });
  };
  // Restarting from the shortest facet after every acceptance is what the queue with re-insertion amounts to.
  for (std::size_t k = 0; !done();) {
    const Facet f = complex.facet(order[k++]);
    if (chosen.contains(f) || !wanted(f)) continue;
    chosen.insert(f);
    for (const VertexIndex v : f) {
      used.insert(v);
      const std::size_t from = tree[v];
      std::ranges::replace(tree, from, tree[f[0]]);
    }
    k = 0;
  }
  return chosen;
}

TEST(BoundaryComplex, agrees_with_the_printed_algorithm_made_from_scratch) {
  for (const Fixture& f : fixtures(1000, 150)) {
    if (f.complex.points() > 24) continue;
    for (const bool connected : {true, false}) {
      Context context;
      const auto fast = boundary_complex(f.complex, Criterion(f.complex), connected, context);
      ASSERT_TRUE(fast);
      std::set<std::array<VertexIndex, 3>> facets;
      for (std::size_t s = 0; s < 4 * f.complex.cells(); ++s) {
        ASSERT_EQ(fast->facets.contains(SideIndex(s)), fast->facets.contains(f.complex.mate(s)));
        if (fast->facets.contains(SideIndex(s))) facets.insert(f.complex.facet(SideIndex(s)));
      }
      EXPECT_EQ(facets, slow_boundary_complex(f.complex, connected));
      EXPECT_EQ(facets.size(), fast->size);
    }
  }
}

TEST(BoundaryComplex, has_no_boundary_edge_and_uses_every_point) {
  for (const Fixture& f : fixtures(2000, 200)) {
    Context context;
    const auto boundary = boundary_complex(f.complex, Criterion(f.complex), true, context);
    std::map<std::pair<VertexIndex, VertexIndex>, int> uses;
    std::set<VertexIndex> used;
    for (std::size_t s = 0; s < 4 * f.complex.cells(); ++s) {
      if (!boundary->facets.contains(SideIndex(s)) || s > f.complex.mate(s)) continue;
      const auto [a, b, c] = f.complex.facet(SideIndex(s));
      used.insert({a, b, c});
      ++uses[{a, b}];
      ++uses[{a, c}];
      ++uses[{b, c}];
    }
    EXPECT_EQ(used.size(), f.complex.points());
    for (const auto& [edge, count] : uses) EXPECT_GE(count, 2);
  }
}

TEST(Inflating, makes_every_vertex_good_from_any_labels_and_only_takes_cells_in) {
  std::mt19937 random(3);
  for (const Fixture& f : fixtures(3000, 300)) {
    const Criterion criterion(f.complex);
    Context context;
    const auto boundary = boundary_complex(f.complex, criterion, true, context);
    Labelling labels = random_labels(f.complex, random);
    const Labelling before = labels;
    const auto inflated = inflate(labels, boundary->facets, criterion, context, 1);
    ASSERT_TRUE(inflated);
    EXPECT_EQ(inflated->forced, 0U);
    for (std::size_t v = 0; v < f.complex.points(); ++v) EXPECT_TRUE(good(labels.state(VertexIndex(v))));
    for (std::size_t c = 0; c < f.complex.cells(); ++c) {
      EXPECT_TRUE(labels.in(CellIndex(c)) || !before.in(CellIndex(c)));
      EXPECT_FALSE(labels.in(CellIndex(c)) && f.complex.infinite(CellIndex(c)));
    }
  }
}

TEST(Descent, keeps_topology_and_lowers_interior_vertices_and_energy_in_this_order) {
  std::mt19937 random(4);
  for (const Fixture& f : fixtures(4000, 300)) {
    const Criterion criterion(f.complex);
    Context context;
    const auto boundary = boundary_complex(f.complex, criterion, true, context);
    Labelling labels = random_labels(f.complex, random);
    ASSERT_TRUE(inflate(labels, boundary->facets, criterion, context, 1));
    const Measures before = measure(labels, criterion);
    const auto descent = descend(labels, criterion, context, 1);
    ASSERT_TRUE(descent);
    const Measures after = measure(labels, criterion);
    EXPECT_EQ(after.euler(), before.euler());
    EXPECT_EQ(after.components, before.components);
    EXPECT_EQ(after.interior + descent->exposed, before.interior);
    EXPECT_TRUE(after.interior < before.interior || after.energy <= before.energy);
    for (std::size_t v = 0; v < f.complex.points(); ++v) EXPECT_TRUE(good(labels.state(VertexIndex(v))));
  }
}

TEST(Hull, flood_stops_at_walls_and_nowhere_else) {
  for (const Fixture& f : fixtures(5000, 40)) {
    Context context;
    const auto boundary = boundary_complex(f.complex, Criterion(f.complex), true, context);
    const auto behind = cells_behind(f.complex, boundary->facets);
    for (std::size_t s = 0; s < 4 * f.complex.cells(); ++s) {
      if (!boundary->facets.contains(SideIndex(s))) {
        EXPECT_EQ(behind[s / 4], behind[f.complex.mate(s) / 4]);
      }
      if (f.complex.infinite(CellIndex(s / 4))) {
        EXPECT_EQ(behind[s / 4], 0);
      }
    }
  }
}

/// K from the triangles alone.
double bending_of(const TriangleMesh& mesh) {
  std::map<std::pair<std::size_t, std::size_t>, Point3> normal_at;
  for (const Triangle& t : mesh.triangles) {
    const Point3 normal =
        cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    for (std::size_t i = 0; i < 3; ++i) normal_at[{t[i], t[(i + 1) % 3]}] = normal;
  }
  double sum = 0;
  for (const auto& [edge, m] : normal_at) {
    if (edge.first > edge.second) continue;
    const Point3 n = normal_at.at({edge.second, edge.first});
    sum += std::atan2(norm(cross(m, n)), dot(m, n)) * norm(mesh.positions[edge.first] - mesh.positions[edge.second]);
  }
  return sum;
}

TEST(Curvature, reduction_is_what_flipping_every_cell_in_turn_gains_measured_on_the_triangles) {
  std::size_t compared = 0;
  for (const Fixture& f : fixtures(7000, 120)) {
    if (f.complex.points() > 40 || f.complex.scale != 1) continue;
    const Criterion criterion(f.complex);
    Context context;
    const auto boundary = boundary_complex(f.complex, criterion, true, context);
    Labelling labels(f.complex);
    ASSERT_TRUE(inflate(labels, boundary->facets, criterion, context, 1));
    const double reduction = curvature_reduction(labels, 1);
    EXPECT_EQ(reduction, curvature_reduction(labels, 3));
    const double total = bending_of(surface_of(labels, f.cloud));
    const auto improves = [&](Labelling& now, std::size_t c) {
      if (f.complex.infinite(CellIndex(c)) || std::popcount(now.border(CellIndex(c))) != 2) return false;
      if (!flip_is_legal(now, CellIndex(c))) return false;
      const double before = bending_of(surface_of(now, f.cloud));
      now.flip(CellIndex(c));
      if (bending_of(surface_of(now, f.cloud)) < before - 1e-9 * total) return true;
      now.flip(CellIndex(c));
      return false;
    };
    std::vector<std::size_t> wanted;
    for (std::size_t c = 0; c < f.complex.cells(); ++c) {
      Labelling tried = labels;
      if (improves(tried, c)) wanted.push_back(c);
    }
    Labelling flipped = labels;
    for (const std::size_t c : wanted) improves(flipped, c);
    EXPECT_NEAR(reduction, 100 * (1 - bending_of(surface_of(flipped, f.cloud)) / total), 1e-4);
    ++compared;
  }
  EXPECT_GT(compared, 10U);
}

/// Shortest augmenting paths from the outside to the seeds, one unit of every cell a node: the cells that are out
/// of reach when there are no more.
std::vector<std::uint8_t> slow_cells_behind_cut(const DelaunayComplex& complex, const FacetSet& boundary,
                                                const Criterion& criterion, const std::vector<std::uint8_t>& seeds) {
  std::vector<std::int64_t> rest(4 * complex.cells(), 0);
  for (std::size_t s = 0; s < rest.size(); ++s) {
    if (!boundary.contains(SideIndex(s)) && complex.facet(SideIndex(s))[2] < complex.points()) {
      rest[s] = criterion.energy(SideIndex(s));
    }
  }
  for (;;) {
    std::vector<std::int64_t> came_by(complex.cells(), -1);
    std::vector<std::size_t> queue;
    std::vector<std::uint8_t> behind(complex.cells(), 1);
    for (std::size_t c = 0; c < complex.cells(); ++c) {
      if (!complex.infinite(CellIndex(c))) continue;
      queue.push_back(c);
      behind[c] = 0;
    }
    std::size_t end = complex.cells();
    for (std::size_t next = 0; next < queue.size() && end == complex.cells(); ++next) {
      const std::size_t c = queue[next];
      for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
        const std::size_t beyond = complex.neighbour(SideIndex(s));
        if (rest[s] == 0 || behind[beyond] == 0) continue;
        behind[beyond] = 0;
        came_by[beyond] = static_cast<std::int64_t>(s);
        queue.push_back(beyond);
        if (seeds[beyond] != 0) end = beyond;
      }
    }
    if (end == complex.cells()) return behind;
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (std::size_t c = end; came_by[c] >= 0; c = static_cast<std::size_t>(came_by[c]) / 4) {
      least = std::min(least, rest[static_cast<std::size_t>(came_by[c])]);
    }
    for (std::size_t c = end; came_by[c] >= 0; c = static_cast<std::size_t>(came_by[c]) / 4) {
      rest[static_cast<std::size_t>(came_by[c])] -= least;
      rest[complex.mate(static_cast<std::size_t>(came_by[c]))] += least;
    }
  }
}

TEST(MinCut, agrees_with_shortest_augmenting_paths_and_is_the_cut_nearest_to_infinity) {
  std::mt19937 random(5);
  for (const Fixture& f : fixtures(6000, 300)) {
    const Criterion criterion(f.complex);
    Context context;
    const auto boundary = boundary_complex(f.complex, criterion, true, context);
    std::vector<std::uint8_t> seeds(f.complex.cells(), 0);
    const auto share = 2 + random() % 20;
    for (std::size_t c = 0; c < seeds.size(); ++c) {
      seeds[c] = !f.complex.infinite(CellIndex(c)) && random() % share == 0 ? 1 : 0;
    }
    // With the whole boundary complex most seeds are shut off already: also with half of it.
    FacetSet walls = boundary->facets;
    for (std::size_t s = 0; s < 4 * f.complex.cells(); ++s) {
      if (walls.contains(SideIndex(s)) && random() % 2 == 0) walls.erase(f.complex, SideIndex(s));
    }
    for (const FacetSet& set : {boundary->facets, walls}) {
      const auto behind = cells_behind_cut(f.complex, set, criterion, seeds, context);
      ASSERT_TRUE(behind);
      EXPECT_EQ(*behind, slow_cells_behind_cut(f.complex, set, criterion, seeds));
    }
  }
}

TEST(MinCut, stops_within_the_flow_when_cancelled) {
  const PointCloud cloud = *make_cloud(testing::raw_cloud(testing::random_points(3000, 1)));
  Context free;
  const auto complex = delaunay_complex(cloud, free, 1);
  const std::atomic<bool> cancel{true};
  Context context(1, {}, &cancel);
  std::vector<std::uint8_t> seeds(complex->cells(), 0);
  for (std::size_t c = 0; c < seeds.size(); c += 7) seeds[c] = complex->infinite(CellIndex(c)) ? 0 : 1;
  const auto behind = cells_behind_cut(*complex, FacetSet(*complex), Criterion(*complex), seeds, context);
  ASSERT_FALSE(behind);
  EXPECT_EQ(behind.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace surfaced::boundary
