#include "minimum_boundary/watershed.hpp"

#include <algorithm>
#include <bit>
#include <unordered_set>

#include "base/parallel.hpp"
#include "base/union_find.hpp"
#include "minimum_boundary/ball_ratio.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFU;
constexpr std::size_t kCancelStride = 1U << 16U;
/// Fewer BC_0 facets than this on a cluster's border prove nothing.
constexpr std::uint32_t kFewestItems = 4;
/// Share of a cluster's BC_0 facets beyond which the other cluster lies on the other side.
constexpr double kGuardShare = 0.3;

/// The order by ratio jumps about in memory: so many facets ahead, what they need is asked for.
constexpr std::size_t kFar = 16;
constexpr std::size_t kNear = 8;
constexpr std::size_t kSteps = 1U << 16U;

/// Facets outside BC_0 at or above the lowest level, descending by ratio, ties by side.
struct DescendingFacets {
  std::vector<SideIndex> sides;
  /// Number of facets at or above each level.
  std::vector<std::size_t> ends;
};

DescendingFacets descending(const DelaunayComplex& complex, const FacetSet& boundary, const RatedFacets& rated,
                            std::span<const float> levels) {
  const std::uint32_t lowest = RatedFacets::step_of(levels.back());
  const auto listed = [&](std::size_t s) {
    return rated.steps[s] >= lowest && s < complex.mate(s) && !boundary.contains(SideIndex(s));
  };
  std::vector<std::size_t> starts(kSteps + 1, 0);
  for (std::size_t s = 0; s < rated.steps.size(); ++s) {
    if (listed(s)) ++starts[kSteps - rated.steps[s]];
  }
  for (std::size_t b = 0; b < kSteps; ++b) starts[b + 1] += starts[b];
  DescendingFacets facets;
  facets.sides.resize(starts[kSteps]);
  for (const float level : levels) facets.ends.push_back(starts[kSteps - RatedFacets::step_of(level)]);
  for (std::size_t s = 0; s < rated.steps.size(); ++s) {
    if (listed(s)) facets.sides[starts[kSteps - 1 - rated.steps[s]]++] = SideIndex(s);
  }
  return facets;
}

class Merger {
 public:
  Merger(const DelaunayComplex& complex, const std::vector<std::uint8_t>& evidence)
      : complex_(complex),
        evidence_(evidence),
        sets_(complex.cells()),
        next_(complex.cells(), kNone),
        last_(complex.cells(), kNone),
        items_(complex.cells(), 0),
        partners_of_(complex.cells(), kNone) {
    for (std::size_t c = 0; c < complex.cells(); ++c) {
      items_[c] = static_cast<std::uint32_t>(std::popcount(evidence[c]));
      if (items_[c] > 0) last_[c] = static_cast<std::uint32_t>(c);
    }
    std::uint32_t outside = kNone;
    for (std::size_t c = 0; c < complex.cells(); ++c) {
      if (!complex.infinite(CellIndex(c))) continue;
      if (outside != kNone) merge(sets_.find(outside), sets_.find(c));
      outside = static_cast<std::uint32_t>(c);
    }
    outside_ = outside;
  }

  void prefetch(SideIndex far, SideIndex near) const {
    __builtin_prefetch(&complex_.table[far / 4]);
    sets_.prefetch(far / 4);
    sets_.prefetch(complex_.mate(near) / 4);
  }

  void take(SideIndex side) {
    const std::uint32_t a = sets_.find(side / 4);
    const std::uint32_t b = sets_.find(complex_.mate(side) / 4);
    if (a == b || apart(a, b)) return;
    if (opposed(a, b)) {
      keep_apart(a, b);
    } else {
      merge(a, b);
    }
  }

  Clusters snapshot() {
    Clusters clusters{std::vector<std::uint32_t>(complex_.cells()), sets_.find(outside_)};
    for (std::size_t c = 0; c < complex_.cells(); ++c) clusters.cluster[c] = sets_.find(c);
    return clusters;
  }

 private:
  static std::uint64_t pair(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
  }
  /// Cells with evidence of a cluster form a list that begins at its root or, where that has none, after it.
  std::uint32_t first_item(std::uint32_t root) const { return evidence_[root] != 0 ? root : next_[root]; }

  /// Enough of the evidence around the cluster with less of it points at the other one.
  bool opposed(std::uint32_t a, std::uint32_t b) {
    if (items_[b] < items_[a]) std::swap(a, b);
    if (items_[a] < kFewestItems) return false;
    std::uint32_t count = 0;
    for (std::uint32_t c = first_item(a); c != kNone; c = next_[c]) {
      for (unsigned bits = evidence_[c]; bits != 0; bits &= bits - 1) {
        const std::size_t side = 4 * std::size_t{c} + static_cast<std::size_t>(std::countr_zero(bits));
        if (sets_.find(complex_.mate(side) / 4) == b) ++count;
      }
    }
    return count > kGuardShare * items_[a];
  }

  bool apart(std::uint32_t a, std::uint32_t b) const {
    return partners_of_[a] != kNone && partners_of_[b] != kNone && apart_.contains(pair(a, b));
  }

  std::vector<std::uint32_t>& partners(std::uint32_t root) {
    if (partners_of_[root] == kNone) {
      partners_of_[root] = static_cast<std::uint32_t>(partners_.size());
      partners_.emplace_back();
    }
    return partners_[partners_of_[root]];
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
    items_[root] += items_[gone];
    if (partners_of_[gone] != kNone) inherit(root, gone);
  }

  void append_items(std::uint32_t root, std::uint32_t gone) {
    if (last_[gone] == kNone) return;
    const std::uint32_t first = first_item(gone);
    next_[last_[root] == kNone ? root : last_[root]] = first;
    last_[root] = last_[gone];
  }

  /// Whoever was kept apart from `gone` is now kept apart from `root`.
  void inherit(std::uint32_t root, std::uint32_t gone) {
    const std::vector<std::uint32_t> moved = std::move(partners_[partners_of_[gone]]);
    partners_of_[gone] = kNone;
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

  const DelaunayComplex& complex_;
  const std::vector<std::uint8_t>& evidence_;
  UnionFind sets_;
  std::vector<std::uint32_t> next_;
  std::vector<std::uint32_t> last_;
  /// Evidence facets of each cluster, at its root.
  std::vector<std::uint32_t> items_;
  std::vector<std::uint32_t> partners_of_;
  std::vector<std::vector<std::uint32_t>> partners_;
  /// Few pairs are ever kept apart; most lookups stop at partners_of_.
  std::unordered_set<std::uint64_t> apart_;
  std::uint32_t outside_ = 0;
};

}  // namespace

std::vector<std::uint8_t> inside_of(const Clusters& clusters) {
  std::vector<std::uint8_t> in(clusters.cluster.size());
  for (std::size_t c = 0; c < in.size(); ++c) in[c] = clusters.cluster[c] != clusters.outside ? 1 : 0;
  return in;
}

RatedFacets rate_facets(const DelaunayComplex& complex, const FacetSet& boundary, unsigned threads) {
  const BallRatio ratio(complex, threads);
  RatedFacets rated{std::vector<std::uint16_t>(4 * complex.cells(), 0), std::vector<std::uint8_t>(complex.cells(), 0)};
  parallel_ranges(threads, complex.cells(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
        const bool wall = boundary.contains(SideIndex(s));
        if (!wall && s > complex.mate(s)) continue;
        const float value = ratio.of(SideIndex(s));
        rated.steps[s] = static_cast<std::uint16_t>(RatedFacets::step_of(value));
        if (wall && value < RatedFacets::kEvidenceBelow) rated.evidence[c] |= static_cast<std::uint8_t>(1U << (s % 4));
      }
    }
  });
  return rated;
}

Result<std::vector<Clusters>> guarded_watershed(const DelaunayComplex& complex, const FacetSet& boundary,
                                                const RatedFacets& rated, std::span<const float> levels,
                                                Context& context) {
  const DescendingFacets facets = descending(complex, boundary, rated, levels);
  Merger merger(complex, rated.evidence);
  std::vector<Clusters> at_levels;
  std::size_t next = 0;
  for (const std::size_t end : facets.ends) {
    for (; next < end; ++next) {
      if (next % kCancelStride == 0) {
        if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled in the watershed"};
        context.report(static_cast<double>(next) / static_cast<double>(facets.sides.size()));
      }
      const std::size_t last = facets.sides.size() - 1;
      merger.prefetch(facets.sides[std::min(next + kFar, last)], facets.sides[std::min(next + kNear, last)]);
      merger.take(facets.sides[next]);
    }
    at_levels.push_back(merger.snapshot());
  }
  return at_levels;
}

}  // namespace surfaced::boundary
