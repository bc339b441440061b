// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/bridging.hpp"

#include <algorithm>
#include <limits>
#include <queue>

#include "base/union_find.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/measures.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kMostBridges = 64;
constexpr std::uint32_t kNoBridge = 0xFFFFFFFFU;

/// Surface components by their least vertex.
UnionFind components_of(const Labelling& labels) {
  const DelaunayComplex& complex = labels.complex();
  UnionFind parts(complex.points());
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (!labels.in(CellIndex(s / 4)) || !labels.on_border(SideIndex(s))) continue;
    const auto [a, b, c] = complex.facet(SideIndex(s));
    parts.unite(a, b);
    parts.unite(a, c);
  }
  return parts;
}

/// Least vertices of the components, fewest facets first.
std::vector<std::uint32_t> by_size(const Labelling& labels, UnionFind& parts) {
  const DelaunayComplex& complex = labels.complex();
  std::vector<std::size_t> facets(complex.points(), 0);
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (labels.in(CellIndex(s / 4)) && labels.on_border(SideIndex(s)))
      ++facets[parts.find(complex.facet(SideIndex(s))[0])];
  }
  std::vector<std::uint32_t> order;
  for (std::size_t v = 0; v < facets.size(); ++v) {
    if (facets[v] > 0) order.push_back(static_cast<std::uint32_t>(v));
  }
  std::ranges::stable_sort(order, {}, [&](std::uint32_t v) { return facets[v]; });
  return order;
}

/// The cheapest chain of finite cells of one label from a component to any other; empty if there is none.
std::vector<CellIndex> chain(const Labelling& labels, UnionFind& parts, std::uint32_t from, bool in,
                             const Criterion& criterion) {
  const DelaunayComplex& complex = labels.complex();
  const auto meets = [&](CellIndex c, bool own) {
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
      if (labels.on_border(SideIndex(s)) && (parts.find(complex.facet(SideIndex(s))[0]) == from) == own) return true;
    }
    return false;
  };
  const auto cost = [&](CellIndex c) {
    std::int64_t sum = 1;
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
      if (!labels.on_border(SideIndex(s))) sum += criterion.energy(SideIndex(s));
    }
    return sum;
  };
  using Entry = std::pair<std::int64_t, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<std::int64_t> distance(complex.cells(), std::numeric_limits<std::int64_t>::max());
  std::vector<std::uint32_t> previous(complex.cells(), kNoBridge);
  const auto reach = [&](CellIndex c, std::int64_t length, std::uint32_t before) {
    if (complex.infinite(c) || labels.in(c) != in || length >= distance[c]) return;
    distance[c] = length;
    previous[c] = before;
    queue.push({length, c.value});
  };
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    if (labels.border(CellIndex(c)) != 0 && labels.in(CellIndex(c)) == in && !complex.infinite(CellIndex(c)) &&
        meets(CellIndex(c), true)) {
      reach(CellIndex(c), cost(CellIndex(c)), kNoBridge);
    }
  }
  while (!queue.empty()) {
    const auto [length, cell] = queue.top();
    queue.pop();
    const CellIndex c{std::size_t{cell}};
    if (length != distance[c]) continue;
    if (meets(c, false)) {
      std::vector<CellIndex> cells;
      for (std::uint32_t at = cell; at != kNoBridge; at = previous[at]) cells.emplace_back(at);
      return cells;
    }
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
      const CellIndex next = complex.neighbour(SideIndex(s));
      if (!complex.infinite(next) && labels.in(next) == in) reach(next, length + cost(next), cell);
    }
  }
  return {};
}

}  // namespace

Result<Bridged> bridge(Labelling& labels, const FacetSet& boundary, const Criterion& criterion, std::size_t wanted,
                       const Context& context, unsigned threads) {
  std::size_t components = measure(labels, criterion).components;
  Bridged bridged{components, components};
  for (std::size_t bridges = 0; bridged.components > wanted && bridges < kMostBridges; ++bridges) {
    UnionFind parts = components_of(labels);
    bool joined = false;
    std::size_t tries = 0;
    for (const std::uint32_t part : by_size(labels, parts)) {
      if (joined || ++tries > kMostBridges) break;
      for (const bool in : {false, true}) {
        if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled while bridging"};
        const std::vector<CellIndex> cells = chain(labels, parts, part, in, criterion);
        if (cells.empty()) continue;
        Labelling tried = labels;
        for (const CellIndex c : cells) tried.flip(c);
        const Result<Inflated> inflated = inflate(tried, boundary, criterion, context, threads);
        if (!inflated) return inflated.error();
        components = measure(tried, criterion).components;
        if (components >= bridged.components) continue;
        labels = std::move(tried);
        bridged.components = components;
        joined = true;
        break;
      }
    }
    if (!joined) break;
  }
  return bridged;
}

}  // namespace surfaced::boundary
