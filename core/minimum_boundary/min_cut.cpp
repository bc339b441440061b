// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/min_cut.hpp"

#include <algorithm>
#include <array>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/property_map/property_map.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/cancelled.hpp"
#include "minimum_boundary/hull.hpp"

namespace surfaced::boundary {
namespace {

/// Radii of seeds, in units of the spacing at their vertices.
constexpr std::array kSeedFactors{2.0, 4.0, 8.0};
/// Share of lost points beyond which the outside has leaked in.
constexpr double kMostLeak = 0.1;

using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                                 boost::no_property, std::uint32_t, std::uint32_t>;
using Edge = boost::graph_traits<Graph>::edge_descriptor;
using EdgeNumbers = boost::property_map<Graph, boost::edge_index_t>::const_type;

/// Residual capacities. The library's algorithm has no place to ask whether to go on but its property maps.
class WatchedCapacities {
 public:
  using key_type = Edge;
  using value_type = std::int64_t;
  using reference = std::int64_t&;
  using category = boost::lvalue_property_map_tag;

  WatchedCapacities(std::vector<std::int64_t>& capacities, EdgeNumbers numbers, const Context& context,
                    std::uint64_t& reads)
      : capacities_(&capacities), numbers_(numbers), context_(&context), reads_(&reads) {}

  reference operator[](const Edge& edge) const {
    constexpr std::uint64_t kCancelStride = 1U << 16U;
    if (++*reads_ % kCancelStride == 0) stop_if_cancelled(*context_);
    return (*capacities_)[get(numbers_, edge)];
  }
  friend reference get(const WatchedCapacities& map, const Edge& edge) { return map[edge]; }
  friend void put(const WatchedCapacities& map, const Edge& edge, std::int64_t value) { map[edge] = value; }

 private:
  std::vector<std::int64_t>* capacities_;
  EdgeNumbers numbers_;
  const Context* context_;
  std::uint64_t* reads_;
};

/// The dual graph: a node for all infinite cells, one for all seeds, one for every other cell; an edge in each
/// direction through every facet that is not in the boundary complex.
class Dual {
 public:
  static constexpr std::uint32_t kOutside = 0;
  static constexpr std::uint32_t kInside = 1;

  Dual(const DelaunayComplex& complex, const FacetSet& boundary, const Criterion& criterion,
       const std::vector<std::uint8_t>& seeds)
      : node_of_(complex.cells()) {
    for (std::size_t c = 0; c < node_of_.size(); ++c) {
      node_of_[c] = complex.infinite(CellIndex(c)) ? kOutside : seeds[c] != 0 ? kInside : nodes_++;
    }
    std::vector<std::uint32_t> cells(node_of_.size());
    std::iota(cells.begin(), cells.end(), 0U);
    std::ranges::stable_sort(cells, {}, [&](std::uint32_t c) { return node_of_[c]; });
    std::vector<std::uint32_t> edge_of(4 * node_of_.size(), 0);
    std::vector<SideIndex> sides;
    for (const std::uint32_t c : cells) {
      for (std::size_t s = 4 * std::size_t{c}; s < 4 * std::size_t{c} + 4; ++s) {
        const std::uint32_t beyond = node_of_[complex.neighbour(SideIndex(s))];
        if (beyond == node_of_[c] || boundary.contains(SideIndex(s))) continue;
        edge_of[s] = static_cast<std::uint32_t>(edges_.size());
        edges_.emplace_back(node_of_[c], beyond);
        capacities_.push_back(criterion.energy(SideIndex(s)));
        sides.emplace_back(s);
      }
    }
    reverse_.resize(sides.size());
    for (std::size_t e = 0; e < sides.size(); ++e) reverse_[e] = edge_of[complex.mate(sides[e])];
  }

  /// Fills the graph with a maximal flow; throws Cancelled.
  void saturate(const Context& context) {
    Graph graph(boost::edges_are_sorted, edges_.begin(), edges_.end(), nodes_);
    const std::vector<std::int64_t> capacities = capacities_;
    std::vector<Edge> reverse;
    std::vector<Edge> by_number(edges_.size());
    const EdgeNumbers numbers = get(boost::edge_index, std::as_const(graph));
    const auto [first, last] = boost::edges(graph);
    for (auto edge = first; edge != last; ++edge) by_number[get(numbers, *edge)] = *edge;
    for (const std::uint32_t e : reverse_) reverse.push_back(by_number[e]);
    std::vector<Edge> predecessors(nodes_);
    std::vector<boost::default_color_type> colors(nodes_);
    std::vector<std::int64_t> distances(nodes_);
    const auto nodes = get(boost::vertex_index, graph);
    std::uint64_t reads = 0;
    boost::boykov_kolmogorov_max_flow(graph, boost::make_iterator_property_map(capacities.begin(), numbers),
                                      WatchedCapacities(capacities_, numbers, context, reads),
                                      boost::make_iterator_property_map(reverse.begin(), numbers),
                                      boost::make_iterator_property_map(predecessors.begin(), nodes),
                                      boost::make_iterator_property_map(colors.begin(), nodes),
                                      boost::make_iterator_property_map(distances.begin(), nodes), nodes, kOutside,
                                      kInside);
  }

  /// Per cell 1 unless more could flow to it from outside.
  std::vector<std::uint8_t> behind() const {
    std::vector<std::uint8_t> reached(nodes_, 0);
    std::vector<std::uint32_t> stack{kOutside};
    reached[kOutside] = 1;
    while (!stack.empty()) {
      const std::uint32_t node = stack.back();
      stack.pop_back();
      const auto first = std::ranges::lower_bound(edges_, node, {}, &std::pair<std::uint32_t, std::uint32_t>::first);
      for (auto edge = first; edge != edges_.end() && edge->first == node; ++edge) {
        if (capacities_[static_cast<std::size_t>(edge - edges_.begin())] == 0 || reached[edge->second] != 0) continue;
        reached[edge->second] = 1;
        stack.push_back(edge->second);
      }
    }
    std::vector<std::uint8_t> cells(node_of_.size());
    for (std::size_t c = 0; c < cells.size(); ++c) cells[c] = reached[node_of_[c]] != 0 ? 0 : 1;
    return cells;
  }

 private:
  std::uint32_t nodes_ = 2;
  std::vector<std::uint32_t> node_of_;
  /// Ascending by their first node.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_;
  /// Position of the edge the other way.
  std::vector<std::uint32_t> reverse_;
  /// λ of the facet; after `saturate` what is left of it.
  std::vector<std::int64_t> capacities_;
};

/// Squared λ of the shortest facet of the boundary complex at every vertex.
std::vector<double> spacings(const DelaunayComplex& complex, const FacetSet& boundary, const Criterion& criterion) {
  std::vector<double> spacing(complex.points(), std::numeric_limits<double>::infinity());
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (s > complex.mate(s) || !boundary.contains(SideIndex(s))) continue;
    const double squared = criterion.squared(SideIndex(s));
    for (const VertexIndex v : complex.facet(SideIndex(s))) spacing[v] = std::min(spacing[v], squared);
  }
  return spacing;
}

/// Finite cells behind the lids whose radius is at least `factor` times the spacing at each of their vertices.
std::vector<std::uint8_t> seeds_of(const DelaunayComplex& complex, const BallRatio& ratio,
                                   const std::vector<double>& spacing, std::vector<std::uint8_t> behind,
                                   double factor) {
  for (std::size_t c = 0; c < behind.size(); ++c) {
    if (behind[c] == 0) continue;
    const auto radius = static_cast<double>(ratio.radius(CellIndex(c)));
    double widest = 0;
    for (std::size_t i = 4 * c; i < 4 * c + 4; ++i) widest = std::max(widest, spacing[complex.vertex(i)]);
    // A cell too flat for its ball to be computed says nothing about the room around it.
    if (!std::isfinite(radius) || radius * radius < factor * factor * widest) behind[c] = 0;
  }
  return behind;
}

Covered with_lids(const DelaunayComplex& complex, const FacetSet& boundary, const std::vector<std::uint8_t>& behind) {
  Covered covered{boundary};
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (s > complex.mate(s) || boundary.contains(SideIndex(s))) continue;
    if (behind[s / 4] == behind[complex.neighbour(SideIndex(s))]) continue;
    covered.facets.insert(complex, SideIndex(s));
    ++covered.lids;
  }
  return covered;
}

/// The least and the largest ratio at which the outside does not leak in; if it always does, where it does least.
std::vector<double> sound_deltas(const std::vector<Rung>& rungs, std::size_t points) {
  std::vector<double> sound;
  for (const Rung& rung : rungs) {
    if (static_cast<double>(rung.score.lost) <= kMostLeak * static_cast<double>(points)) sound.push_back(rung.delta);
  }
  if (sound.empty()) return {std::ranges::min_element(rungs, {}, [](const Rung& r) { return r.score.lost; })->delta};
  if (sound.size() == 1) return sound;
  return {sound.front(), sound.back()};
}

}  // namespace

Result<std::vector<std::uint8_t>> cells_behind_cut(const DelaunayComplex& complex, const FacetSet& boundary,
                                                   const Criterion& criterion, const std::vector<std::uint8_t>& seeds,
                                                   const Context& context) {
  Dual dual(complex, boundary, criterion, seeds);
  try {
    dual.saturate(context);
  } catch (const Cancelled&) {
    return Error{ErrorCode::cancelled, "cancelled while cutting"};
  }
  return dual.behind();
}

Result<Covered> cover_by_cut(const DelaunayComplex& complex, const FacetSet& boundary, const Criterion& criterion,
                             std::optional<double> delta, Context& context) {
  const BallRatio ratio(complex, context.threads());
  std::vector<double> deltas;
  if (delta) {
    deltas.push_back(*delta);
  } else {
    const Result<std::vector<Rung>> rungs = climb_ladder(complex, boundary, ratio, context);
    if (!rungs) return rungs.error();
    deltas = sound_deltas(*rungs, complex.points());
  }
  const std::vector<double> spacing = spacings(complex, boundary, criterion);
  Covered best{boundary};
  std::size_t least = flood_score(complex, boundary, context.threads()).sum();
  for (const double level : deltas) {
    const std::vector<std::uint8_t> behind = cells_behind(complex, cover_at(complex, boundary, ratio, level).facets);
    for (const double factor : kSeedFactors) {
      const std::vector<std::uint8_t> seeds = seeds_of(complex, ratio, spacing, behind, factor);
      if (std::ranges::count(seeds, 1) == 0) continue;
      const Result<std::vector<std::uint8_t>> cut = cells_behind_cut(complex, boundary, criterion, seeds, context);
      if (!cut) return cut.error();
      Covered covered = with_lids(complex, boundary, *cut);
      const std::size_t score = flood_score(complex, covered.facets, context.threads()).sum();
      if (score >= least) continue;
      least = score;
      best = std::move(covered);
      best.delta = level;
      best.seed_factor = factor;
    }
  }
  return best;
}

}  // namespace surfaced::boundary
