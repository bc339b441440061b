#include "minimum_boundary/boundary_complex.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <queue>

#include "base/parallel.hpp"
#include "base/union_find.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kCancelStride = 1U << 16U;

/// A facet by the rounded λ² that it is sorted by first.
struct Keyed {
  std::uint32_t key;
  SideIndex side;
};

/// Stable counting sort by 11 bits of the key.
void radix_pass(const std::vector<Keyed>& from, std::vector<Keyed>& to, unsigned shift) {
  constexpr std::size_t kBuckets = 2048;
  std::array<std::size_t, kBuckets + 1> starts{};
  for (const Keyed& k : from) ++starts[((k.key >> shift) & (kBuckets - 1)) + 1];
  for (std::size_t b = 0; b < kBuckets; ++b) starts[b + 1] += starts[b];
  for (const Keyed& k : from) to[starts[(k.key >> shift) & (kBuckets - 1)]++] = k;
}

/// Every finite facet once. The key is λ² rounded to float: rounding is monotone, and the bits of
/// non-negative floats ascend with their values.
std::vector<Keyed> keyed_facets(const DelaunayComplex& complex, const Criterion& criterion, unsigned threads) {
  std::vector<Keyed> keyed;
  keyed.reserve(2 * complex.cells());
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    const unsigned first = complex.infinite(CellIndex(c)) ? 3 : 0;
    for (std::size_t s = 4 * c + first; s < 4 * c + 4; ++s) {
      if (s < complex.mates[s]) keyed.push_back({0, SideIndex(s)});
    }
  }
  parallel_ranges(threads, keyed.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      keyed[k].key = std::bit_cast<std::uint32_t>(static_cast<float>(criterion.squared(keyed[k].side)));
    }
  });
  return keyed;
}

/// Facets in the order of the paper: by rounded key first, then the runs of equal keys exactly.
std::vector<Keyed> facets_by_criterion(const DelaunayComplex& complex, const Criterion& criterion, unsigned threads) {
  std::vector<Keyed> order = keyed_facets(complex, criterion, threads);
  std::vector<Keyed> other(order.size());
  radix_pass(order, other, 0);
  radix_pass(other, order, 11);
  radix_pass(order, other, 22);
  parallel_ranges(threads, other.size(), [&](std::size_t begin, std::size_t end) {
    // A run belongs to the piece in which it begins.
    std::size_t i = begin;
    while (i > 0 && i < end && other[i].key == other[i - 1].key) ++i;
    while (i < end) {
      std::size_t j = i + 1;
      while (j < other.size() && other[j].key == other[i].key) ++j;
      if (j - i > 1) {
        std::sort(other.begin() + static_cast<std::ptrdiff_t>(i), other.begin() + static_cast<std::ptrdiff_t>(j),
                  [&](const Keyed& a, const Keyed& b) { return criterion.less(a.side, b.side); });
      }
      i = j;
    }
  });
  return other;
}

/// Edge of a cell that two of its sides share, by their slots.
constexpr std::array<std::array<std::uint8_t, 4>, 4> kSharedEdge{
    {{6, 5, 4, 3}, {5, 6, 2, 1}, {4, 2, 6, 0}, {3, 1, 0, 6}}};

class Builder {
 public:
  Builder(const DelaunayComplex& complex, const Criterion& criterion, bool connected)
      : complex_(complex),
        criterion_(criterion),
        connected_(connected),
        result_{FacetSet(complex)},
        rejected_(complex),
        edge_uses_(6 * complex.cells(), 0),
        trees_(complex.points()),
        tree_count_(complex.points()),
        used_(complex.points(), false),
        unused_(complex.points()),
        again_(Later{&criterion}) {}

  /// The paper's loop; false if cancelled.
  bool run(const std::vector<Keyed>& order, Context& context) {
    // Facets that come back were rejected before: their λ is below that of all that are still to come.
    for (std::size_t next = 0; !done();) {
      SideIndex side;
      if (again_.empty()) {
        if (next % kCancelStride == 0 && context.cancelled()) return false;
        side = order[next++].side;
      } else {
        side = again_.top().side;
        again_.pop();
      }
      if (wanted(side)) {
        accept(side);
      } else {
        rejected_.insert(complex_, side);
      }
    }
    return true;
  }

  BoundaryComplex take() { return std::move(result_); }

 private:
  struct Returning {
    double squared;
    SideIndex side;
  };
  struct Later {
    const Criterion* criterion;
    bool operator()(const Returning& a, const Returning& b) const {
      return criterion->less(b.side, b.squared, a.side, a.squared);
    }
  };

  bool done() const { return boundary_edges_ == 0 && (connected_ ? tree_count_ == 1 : unused_ == 0); }

  /// Slots of the edges of a facet, as seen from its cell.
  static std::array<std::size_t, 3> edge_slots(SideIndex side) {
    std::array<std::size_t, 3> slots{};
    std::size_t count = 0;
    for (std::size_t j = 0; j < 4; ++j) {
      if (j != side % 4) slots[count++] = 6 * (side / 4) + kSharedEdge[side % 4][j];
    }
    return slots;
  }

  /// The three conditions of Algorithm 1.
  bool wanted(SideIndex side) {
    for (const std::size_t slot : edge_slots(side)) {
      if (edge_uses_[slot] == 1) return true;
    }
    const auto [a, b, c] = complex_.facet(side);
    if (!connected_) return !(used_[a] && used_[b] && used_[c]);
    const std::uint32_t root = trees_.find(a);
    return trees_.find(b) != root || trees_.find(c) != root;
  }

  void accept(SideIndex side) {
    result_.facets.insert(complex_, side);
    ++result_.size;
    const auto facet = complex_.facet(side);
    for (const VertexIndex v : facet) {
      if (connected_) {
        if (trees_.unite(facet[0], v)) --tree_count_;
      } else if (!used_[v]) {
        used_[v] = true;
        --unused_;
      }
    }
    for (std::size_t j = 0; j < 4; ++j) {
      if (j != side % 4) count_use(side, SideIndex(side / 4 * 4 + j));
    }
  }

  /// One more facet at the edge that two sides of a cell share.
  void count_use(SideIndex side, SideIndex exit) {
    const std::uint8_t before = edge_uses_[6 * (side / 4) + kSharedEdge[side % 4][exit % 4]];
    if (before >= 2) return;
    boundary_edges_ += before == 0 ? 1 : -1;
    SideIndex entry = side;
    do {
      const unsigned i = entry % 4;
      const unsigned j = exit % 4;
      edge_uses_[6 * (exit / 4) + kSharedEdge[i][j]] = static_cast<std::uint8_t>(before + 1);
      if (before == 0 && rejected_.contains(exit) && !result_.facets.contains(exit)) come_back(exit);
      // The next cell's way out is opposite the vertex that this cell's way in was opposite to.
      const VertexIndex behind = complex_.vertices[entry];
      entry = complex_.mates[exit];
      std::size_t s = entry / 4 * 4;
      while (complex_.vertices[s] != behind) ++s;
      exit = SideIndex(s);
    } while (entry != side);
  }

  void come_back(SideIndex side) {
    rejected_.erase(complex_, side);
    again_.push({criterion_.squared(side), side});
    ++result_.reinserted;
  }

  const DelaunayComplex& complex_;
  const Criterion& criterion_;
  bool connected_;
  BoundaryComplex result_;
  FacetSet rejected_;
  /// 6 per cell: facets of the result at the edge, counted up to 2.
  std::vector<std::uint8_t> edge_uses_;
  UnionFind trees_;
  std::size_t tree_count_;
  std::vector<bool> used_;
  std::size_t unused_;
  std::ptrdiff_t boundary_edges_ = 0;
  std::priority_queue<Returning, std::vector<Returning>, Later> again_;
};

}  // namespace

Result<BoundaryComplex> boundary_complex(const DelaunayComplex& complex, const Criterion& criterion, bool connected,
                                         Context& context) {
  const std::vector<Keyed> order = facets_by_criterion(complex, criterion, context.threads());
  Builder builder(complex, criterion, connected);
  if (context.cancelled() || !builder.run(order, context)) {
    return Error{ErrorCode::cancelled, "cancelled while building the boundary complex"};
  }
  return builder.take();
}

}  // namespace surfaced::boundary
