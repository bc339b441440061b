#include "minimum_boundary/boundary_complex.hpp"

#include <algorithm>
#include <array>
#include <queue>

#include "base/union_find.hpp"
#include "minimum_boundary/facet_queue.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kCancelStride = 1U << 16U;

/// Edge of a cell that two of its sides share, by their slots.
constexpr std::array<std::array<std::uint8_t, 4>, 4> kSharedEdge{
    {{6, 5, 4, 3}, {5, 6, 2, 1}, {4, 2, 6, 0}, {3, 1, 0, 6}}};

/// What Algorithm 1 knows about a cell, in one word: a walk around an edge touches many cells, and each
/// touch of memory costs more than the bits.
class CellWord {
 public:
  /// Facets of the result at edge k, counted up to 2.
  unsigned uses(std::size_t k) const { return bits_ >> (2 * k) & 3U; }
  void count_use(std::size_t k) { bits_ += 1U << (2 * k); }
  bool chosen(std::size_t i) const { return (bits_ >> (kChosen + i) & 1U) != 0; }
  void choose(std::size_t i) { bits_ |= 1U << (kChosen + i); }
  /// Side i was looked at and not wanted.
  bool rejected(std::size_t i) const { return (bits_ >> (kRejected + i) & 1U) != 0; }
  void reject(std::size_t i) { bits_ |= 1U << (kRejected + i); }
  void forget(std::size_t i) { bits_ &= ~(1U << (kRejected + i)); }

 private:
  static constexpr unsigned kChosen = 12;
  static constexpr unsigned kRejected = 16;
  std::uint32_t bits_ = 0;
};

class Builder {
 public:
  Builder(const DelaunayComplex& complex, const Criterion& criterion, bool connected)
      : complex_(complex),
        criterion_(criterion),
        connected_(connected),
        words_(complex.cells()),
        trees_(complex.points()),
        tree_count_(complex.points()),
        used_(complex.points(), 0),
        unused_(complex.points()),
        again_(Later{&criterion}) {}

  /// The paper's loop; false if cancelled.
  bool run(FacetQueue& queue, Context& context) {
    // Facets that come back were rejected before: their λ is below that of all that are still to come.
    for (std::size_t popped = 0; !spanning();) {
      SideIndex side;
      if (again_.empty()) {
        if (popped++ % kCancelStride == 0 && context.cancelled()) return false;
        side = queue.pop();
        prefetch(queue);
      } else {
        side = again_.top().side;
        again_.pop();
      }
      if (wanted(side)) {
        accept(side);
      } else {
        words_[side / 4].reject(side % 4);
        const SideIndex mate = complex_.mate(side);
        words_[mate / 4].reject(mate % 4);
      }
    }
    close();
    return true;
  }

  BoundaryComplex take() {
    BoundaryComplex result{FacetSet(complex_), size_, reinserted_};
    for (std::size_t c = 0; c < words_.size(); ++c) {
      for (std::size_t i = 0; i < 4; ++i) {
        if (words_[c].chosen(i)) result.facets.insert(complex_, SideIndex(4 * c + i));
      }
    }
    return result;
  }

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

  /// Every vertex is used and (connected) all in one component.
  bool spanning() const { return connected_ ? tree_count_ == 1 : unused_ == 0; }

  /// From then on only facets with a boundary edge are wanted: these are taken by λ among the facets at
  /// boundary edges, which is what the whole queue would give, without looking at all the others.
  void close() {
    closing_ = true;
    for (std::size_t c = 0; c < complex_.cells(); ++c) {
      for (std::size_t k = 0; k < 6; ++k) {
        if (words_[c].uses(k) != 1) continue;
        // The cell's sides at the edge are those opposite the two other vertices.
        const auto [a, b] = kCellEdges[5 - k];
        consider_again(SideIndex(4 * c + a));
        consider_again(SideIndex(4 * c + b));
      }
    }
    while (boundary_edges_ > 0) {
      const SideIndex side = again_.top().side;
      again_.pop();
      if (!words_[side / 4].chosen(side % 4) && wanted(side)) accept(side);
    }
  }

  /// The order by length jumps about in memory: asks for what the coming facets will need.
  void prefetch(const FacetQueue& queue) const {
    constexpr std::size_t kFar = 16;
    constexpr std::size_t kNear = 8;
    const std::size_t far = queue.peek(kFar) / 4;
    __builtin_prefetch(&complex_.table[far]);
    __builtin_prefetch(&words_[far]);
    const SideIndex near = queue.peek(kNear);
    const std::size_t beyond = complex_.mate(near) / 4;
    __builtin_prefetch(&words_[beyond]);
    __builtin_prefetch(&complex_.table[beyond]);
    for (const VertexIndex v : complex_.facet(near)) trees_.prefetch(v);
  }

  /// The three conditions of Algorithm 1.
  bool wanted(SideIndex side) {
    for (std::size_t j = 0; j < 4; ++j) {
      if (j != side % 4 && words_[side / 4].uses(kSharedEdge[side % 4][j]) == 1) return true;
    }
    const auto [a, b, c] = complex_.facet(side);
    if (!connected_) return used_[a] == 0 || used_[b] == 0 || used_[c] == 0;
    const std::uint32_t root = trees_.find(a);
    return trees_.find(b) != root || trees_.find(c) != root;
  }

  void accept(SideIndex side) {
    words_[side / 4].choose(side % 4);
    const SideIndex mate = complex_.mate(side);
    words_[mate / 4].choose(mate % 4);
    ++size_;
    const auto facet = complex_.facet(side);
    for (const VertexIndex v : facet) {
      if (connected_) {
        if (trees_.unite(facet[0], v)) --tree_count_;
      } else if (used_[v] == 0) {
        used_[v] = 1;
        --unused_;
      }
    }
    for (std::size_t j = 0; j < 4; ++j) {
      if (j != side % 4) count_use(side, SideIndex(side / 4 * 4 + j));
    }
  }

  /// One more facet at the edge that two sides of a cell share.
  void count_use(SideIndex side, SideIndex exit) {
    const unsigned before = words_[side / 4].uses(kSharedEdge[side % 4][exit % 4]);
    if (before >= 2) return;
    boundary_edges_ += before == 0 ? 1 : -1;
    SideIndex entry = side;
    do {
      words_[exit / 4].count_use(kSharedEdge[entry % 4][exit % 4]);
      if (before == 0) consider_again(exit);
      // The next cell's way out is opposite the vertex that this cell's way in was opposite to.
      const VertexIndex behind = complex_.vertex(entry);
      entry = complex_.mate(exit);
      std::size_t s = entry / 4 * 4;
      while (complex_.vertex(s) != behind) ++s;
      exit = SideIndex(s);
    } while (entry != side);
  }

  /// Queues a facet that got a boundary edge after it had been passed over.
  void consider_again(SideIndex side) {
    CellWord& word = words_[side / 4];
    const bool rejected = word.rejected(side % 4);
    if (!(rejected || closing_) || word.chosen(side % 4) || complex_.facet(side)[2] == complex_.points()) return;
    if (rejected) {
      const SideIndex mate = complex_.mate(side);
      word.forget(side % 4);
      words_[mate / 4].forget(mate % 4);
      ++reinserted_;
    }
    again_.push({criterion_.squared(side), side});
  }

  const DelaunayComplex& complex_;
  const Criterion& criterion_;
  bool connected_;
  std::vector<CellWord> words_;
  std::size_t size_ = 0;
  std::size_t reinserted_ = 0;
  UnionFind trees_;
  std::size_t tree_count_;
  std::vector<std::uint8_t> used_;
  std::size_t unused_;
  std::ptrdiff_t boundary_edges_ = 0;
  bool closing_ = false;
  std::priority_queue<Returning, std::vector<Returning>, Later> again_;
};

}  // namespace

Result<BoundaryComplex> boundary_complex(const DelaunayComplex& complex, const Criterion& criterion, bool connected,
                                         Context& context) {
  FacetQueue queue(complex, criterion, context.threads());
  Builder builder(complex, criterion, connected);
  if (context.cancelled() || !builder.run(queue, context)) {
    return Error{ErrorCode::cancelled, "cancelled while building the boundary complex"};
  }
  return builder.take();
}

}  // namespace surfaced::boundary
