// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/watershed.hpp"

#include <algorithm>
#include <bit>
#include <unordered_set>

#include "base/parallel.hpp"
#include "base/union_find.hpp"
#include "minimum_boundary/ball_ratio.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::uint32_t kNoBasin = 0xFFFFFFFFU;
constexpr std::size_t kFloodStride = 1U << 16U;
/// Fewer BC_0 facets than this on a cluster's border prove nothing.
constexpr std::uint32_t kFewestItems = 4;
/// Share of a cluster's BC_0 facets beyond which the other cluster lies on the other side.
constexpr double kGuardShare = 0.3;

/// The order by ratio jumps about in memory: so many facets ahead, what they need is asked for.
constexpr std::size_t kFar = 16;
constexpr std::size_t kNear = 8;
constexpr std::size_t kSteps = 1U << 16U;

/// Counting sort of the facets at or above the thorough level.
std::vector<FacetRatings::Passage> descending(const DelaunayComplex& complex, const std::vector<std::uint16_t>& steps) {
  const std::uint32_t lowest = FacetRatings::step_of(kThoroughLevel);
  std::vector<std::size_t> starts(kSteps + 1, 0);
  for (const std::uint16_t step : steps) ++starts[kSteps - step];
  for (std::size_t b = 0; b + lowest < kSteps; ++b) starts[b + 1] += starts[b];
  std::vector<FacetRatings::Passage> passages(starts[kSteps - lowest]);
  for (std::size_t s = 0; s < steps.size(); ++s) {
    if (steps[s] < lowest) continue;
    passages[starts[kSteps - 1 - steps[s]]++] = {SideIndex(s), complex.neighbour(SideIndex(s))};
  }
  return passages;
}

class Merger {
 public:
  Merger(const DelaunayComplex& complex, const std::vector<std::uint8_t>& evidence)
      : sets_(complex.cells()), clusters_(complex.cells()) {
    collect_items(complex, evidence);
    std::uint32_t outside = kNoBasin;
    for (std::size_t c = 0; c < complex.cells(); ++c) {
      if (!complex.infinite(CellIndex(c))) continue;
      if (outside != kNoBasin) merge(sets_.find(outside), sets_.find(c));
      outside = static_cast<std::uint32_t>(c);
    }
    outside_ = outside;
  }

  void prefetch(const FacetRatings::Passage& far, const FacetRatings::Passage& near) const {
    sets_.prefetch(far.side / 4);
    sets_.prefetch(far.beyond);
    for (const std::uint32_t next : {sets_.next(near.side / 4), sets_.next(near.beyond)}) {
      sets_.prefetch(next);
      __builtin_prefetch(&clusters_[next]);
    }
  }

  void take(const FacetRatings::Passage& passage) {
    const std::uint32_t a = sets_.find(passage.side / 4);
    const std::uint32_t b = sets_.find(passage.beyond);
    if (a == b || apart(a, b)) return;
    if (opposed(a, b)) {
      keep_apart(a, b);
    } else {
      merge(a, b);
    }
  }

  Clusters snapshot() {
    Clusters clusters{std::vector<std::uint32_t>(clusters_.size()), sets_.find(outside_)};
    for (std::size_t c = 0; c < clusters_.size(); ++c) clusters.cluster[c] = sets_.find(c);
    return clusters;
  }

 private:
  /// An evidence facet of a cell: the cell beyond it, and the next item of the same cluster.
  struct Item {
    CellIndex beyond;
    std::uint32_t next = kNoBasin;
  };
  /// What is known of a cluster, at its root.
  struct Cluster {
    std::uint32_t first = kNoBasin;
    std::uint32_t last = kNoBasin;
    std::uint32_t items = 0;
    std::uint32_t partners = kNoBasin;
  };

  void collect_items(const DelaunayComplex& complex, const std::vector<std::uint8_t>& evidence) {
    std::size_t count = 0;
    for (const std::uint8_t bits : evidence) count += static_cast<std::size_t>(std::popcount(bits));
    items_.reserve(count);
    for (std::size_t c = 0; c < evidence.size(); ++c) {
      if (evidence[c] == 0) continue;
      const auto first = static_cast<std::uint32_t>(items_.size());
      for (unsigned bits = evidence[c]; bits != 0; bits &= bits - 1) {
        const SideIndex side(4 * c + static_cast<std::size_t>(std::countr_zero(bits)));
        items_.push_back({complex.neighbour(side), static_cast<std::uint32_t>(items_.size() + 1)});
      }
      items_.back().next = kNoBasin;
      const auto end = static_cast<std::uint32_t>(items_.size());
      clusters_[c] = {first, end - 1, end - first, kNoBasin};
    }
  }

  static std::uint64_t pair(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
  }

  /// Enough of the evidence around the cluster with less of it points at the other one.
  bool opposed(std::uint32_t a, std::uint32_t b) {
    if (clusters_[b].items < clusters_[a].items) std::swap(a, b);
    const std::uint32_t items = clusters_[a].items;
    if (items < kFewestItems) return false;
    const double enough = kGuardShare * items;
    std::uint32_t count = 0;
    std::uint32_t left = items;
    for (std::uint32_t k = clusters_[a].first; k != kNoBasin; k = items_[k].next, --left) {
      if (count + left <= enough) return false;
      if (sets_.find(items_[k].beyond) == b && ++count > enough) return true;
    }
    return false;
  }

  bool apart(std::uint32_t a, std::uint32_t b) const {
    return clusters_[a].partners != kNoBasin && clusters_[b].partners != kNoBasin && apart_.contains(pair(a, b));
  }

  std::vector<std::uint32_t>& partners(std::uint32_t root) {
    if (clusters_[root].partners == kNoBasin) {
      clusters_[root].partners = static_cast<std::uint32_t>(partners_.size());
      partners_.emplace_back();
    }
    return partners_[clusters_[root].partners];
  }

  void keep_apart(std::uint32_t a, std::uint32_t b) {
    apart_.insert(pair(a, b));
    partners(a).push_back(b);
    partners(b).push_back(a);
  }

  void merge(std::uint32_t a, std::uint32_t b) {
    sets_.unite(a, b);
    const std::uint32_t root = sets_.find(a);
    const std::uint32_t gone = root == a ? b : a;
    append_items(root, gone);
    clusters_[root].items += clusters_[gone].items;
    if (clusters_[gone].partners != kNoBasin) inherit(root, gone);
  }

  void append_items(std::uint32_t root, std::uint32_t gone) {
    if (clusters_[gone].last == kNoBasin) return;
    (clusters_[root].last == kNoBasin ? clusters_[root].first : items_[clusters_[root].last].next) =
        clusters_[gone].first;
    clusters_[root].last = clusters_[gone].last;
  }

  /// Whoever was kept apart from `gone` is now kept apart from `root`.
  void inherit(std::uint32_t root, std::uint32_t gone) {
    const std::vector<std::uint32_t> moved = std::move(partners_[clusters_[gone].partners]);
    clusters_[gone].partners = kNoBasin;
    for (const std::uint32_t old : moved) {
      const std::uint32_t other = sets_.find(old);
      if (other == root) continue;
      apart_.erase(pair(gone, old));
      if (apart_.insert(pair(root, other)).second) {
        partners(root).push_back(other);
        partners(other).push_back(root);
      }
    }
  }

  UnionFind sets_;
  std::vector<Cluster> clusters_;
  std::vector<Item> items_;
  std::vector<std::vector<std::uint32_t>> partners_;
  /// Few pairs are ever kept apart; most lookups stop at the clusters.
  std::unordered_set<std::uint64_t> apart_;
  std::uint32_t outside_ = 0;
};

}  // namespace

std::vector<std::uint8_t> inside_of(const Clusters& clusters) {
  std::vector<std::uint8_t> in(clusters.cluster.size());
  for (std::size_t c = 0; c < in.size(); ++c) in[c] = clusters.cluster[c] != clusters.outside ? 1 : 0;
  return in;
}

FacetRatings rate_facets(const DelaunayComplex& complex, unsigned threads) {
  FacetRatings ratings{
      std::vector<std::uint16_t>(4 * complex.cells(), 0), std::vector<std::uint8_t>(complex.cells(), 0), {}};
  {
    const BallRatio ratio(complex, threads);
    parallel_ranges(threads, complex.cells(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) {
        for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
          if (s > complex.mate(s)) continue;
          const float value = ratio.of(SideIndex(s));
          ratings.steps[s] = static_cast<std::uint16_t>(FacetRatings::step_of(value));
          if (value < RatedFacets::kEvidenceBelow) ratings.low[c] |= static_cast<std::uint8_t>(1U << (s % 4));
        }
      }
    });
  }
  ratings.passages = descending(complex, ratings.steps);
  return ratings;
}

RatedFacets with_evidence(const DelaunayComplex& complex, FacetRatings ratings, const FacetSet& boundary,
                          unsigned threads) {
  RatedFacets rated{std::move(ratings.steps), std::vector<std::uint8_t>(complex.cells(), 0),
                    std::move(ratings.passages)};
  parallel_ranges(threads, complex.cells(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      for (unsigned bits = boundary.of_cell(CellIndex(c)); bits != 0; bits &= bits - 1) {
        const SideIndex s(4 * c + static_cast<std::size_t>(std::countr_zero(bits)));
        const SideIndex lesser = std::min(s, complex.mate(s));
        if (s != lesser) rated.steps[s] = rated.steps[lesser];
        if ((unsigned{ratings.low[lesser / 4]} >> (lesser % 4) & 1U) == 0) continue;
        rated.evidence[c] |= static_cast<std::uint8_t>(1U << (s % 4));
      }
    }
  });
  return rated;
}

Result<std::vector<Clusters>> guarded_watershed(const DelaunayComplex& complex, const FacetSet& boundary,
                                                const RatedFacets& rated, std::span<const float> levels,
                                                Context& context) {
  const std::vector<FacetRatings::Passage>& passages = rated.passages;
  Merger merger(complex, rated.evidence);
  std::vector<Clusters> at_levels;
  std::size_t next = 0;
  for (const float level : levels) {
    const std::uint32_t lowest = FacetRatings::step_of(level);
    const auto end = static_cast<std::size_t>(
        std::ranges::partition_point(passages, [&](const auto& p) { return rated.steps[p.side] >= lowest; }) -
        passages.begin());
    for (; next < end; ++next) {
      if (next % kFloodStride == 0) {
        if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled in the watershed"};
        context.report(static_cast<double>(next) / static_cast<double>(passages.size()));
      }
      const std::size_t last = passages.size() - 1;
      merger.prefetch(passages[std::min(next + kFar, last)], passages[std::min(next + kNear, last)]);
      if (!boundary.contains(passages[next].side)) merger.take(passages[next]);
    }
    at_levels.push_back(merger.snapshot());
  }
  return at_levels;
}

}  // namespace surfaced::boundary
