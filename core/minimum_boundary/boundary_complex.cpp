// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/boundary_complex.hpp"

#include <algorithm>
#include <array>
#include <queue>

#include "base/parallel.hpp"
#include "base/union_find.hpp"
#include "minimum_boundary/facet_queue.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kBlockStride = 1U << 8U;

/// What Algorithm 1 knows about the sides of a cell.
class CellByte {
 public:
  bool chosen(std::size_t i) const { return (bits_ >> i & 1U) != 0; }
  void choose(std::size_t i) { bits_ |= static_cast<std::uint8_t>(1U << i); }
  /// Side i was looked at and not wanted.
  bool rejected(std::size_t i) const { return (bits_ >> (kRejected + i) & 1U) != 0; }
  void reject(std::size_t i) { bits_ |= static_cast<std::uint8_t>(1U << (kRejected + i)); }
  void forget(std::size_t i) { bits_ &= static_cast<std::uint8_t>(~(1U << (kRejected + i))); }
  std::uint8_t all_chosen() const { return bits_ & ((1U << kRejected) - 1); }

 private:
  static constexpr unsigned kRejected = 4;
  std::uint8_t bits_ = 0;
};

/// Facets of the result at an edge, counted up to 2, and whether a rejected facet waits there for the edge to
/// become a boundary edge. Only then are the facets at the edge visited.
class EdgeByte {
 public:
  unsigned uses() const { return bits_ & kUses; }
  void count_use() { ++bits_; }
  bool waited_for() const { return (bits_ & kWaitedFor) != 0; }
  void wait() { bits_ |= kWaitedFor; }

 private:
  static constexpr unsigned kUses = 3;
  static constexpr unsigned kWaitedFor = 4;
  std::uint8_t bits_ = 0;
};

class Builder {
 public:
  Builder(const DelaunayComplex& complex, const Criterion& criterion, bool connected, unsigned threads)
      : complex_(complex),
        criterion_(criterion),
        connected_(connected),
        numbering_(number_edges(complex, threads)),
        edges_(numbering_.edges()),
        cells_(complex.cells()),
        trees_(complex.points()),
        tree_count_(complex.points()),
        used_(complex.points(), 0),
        unused_(complex.points()) {}

  /// The paper's loop; false if cancelled.
  bool run(FacetQueue& queue, Context& context) {
    for (std::size_t blocks = 0; !spanning(); ++blocks) {
      if (blocks % kBlockStride == 0 && context.cancelled()) return false;
      list(queue.next_block());
      for (const Listed& facet : block_) {
        take(facet);
        // Facets that come back were rejected before: their λ is below that of all that are still to come.
        while (!again_.empty() && !spanning()) take(pop_again());
        if (spanning()) break;
      }
    }
    close();
    return true;
  }

  BoundaryComplex result() const {
    std::vector<std::uint8_t> sides(cells_.size());
    for (std::size_t c = 0; c < sides.size(); ++c) sides[c] = cells_[c].all_chosen();
    return {FacetSet(std::move(sides)), size_, reinserted_};
  }

 private:
  using Vertices = std::array<VertexIndex, 3>;
  struct Listed {
    SideIndex side;
    Vertices vertices;
    /// Edge j lacks vertex j.
    std::array<EdgeIndex, 3> edges;
  };
  struct Returning {
    std::array<double, 3> squares;
    Vertices vertices;
    SideIndex side;
    friend bool operator<(const Returning& a, const Returning& b) {
      return a.squares != b.squares ? b.squares < a.squares : b.vertices < a.vertices;
    }
  };

  Listed listed(SideIndex side, const Vertices& v) const {
    return {side, v, {numbering_.find(v[1], v[2]), numbering_.find(v[0], v[2]), numbering_.find(v[0], v[1])}};
  }

  void list(std::span<const ListedFacet> facets) {
    for (const ListedFacet& facet : facets) {
      numbering_.prefetch(facet.vertices[0]);
      numbering_.prefetch(facet.vertices[1]);
    }
    block_.resize(facets.size());
    for (std::size_t k = 0; k < facets.size(); ++k) block_[k] = listed(facets[k].side, facets[k].vertices);
  }

  Listed pop_again() {
    const Returning top = again_.top();
    again_.pop();
    return listed(top.side, top.vertices);
  }

  void take(const Listed& facet) {
    if (wanted(facet)) {
      accept(facet);
    } else {
      reject(facet);
    }
  }

  /// Every vertex is used and (connected) all in one component.
  bool spanning() const { return connected_ ? tree_count_ == 1 : unused_ == 0; }

  /// From then on only facets with a boundary edge are wanted: these are taken by λ among the facets at
  /// boundary edges, which is what the whole queue would give, without looking at all the others.
  void close() {
    closing_ = true;
    for (std::size_t v = 0; v < complex_.points(); ++v) {
      const auto first = edges_.begin() + numbering_.starts[v];
      const auto last = edges_.begin() + numbering_.starts[v + 1];
      if (std::none_of(first, last, [](EdgeByte e) { return e.uses() == 1; })) continue;
      for (const SideIndex corner : complex_.star(VertexIndex(v))) consider_edges_at(corner);
    }
    while (boundary_edges_ > 0) {
      const Listed facet = pop_again();
      if (!cells_[facet.side / 4].chosen(facet.side % 4) && wanted(facet)) accept(facet);
    }
  }

  /// Queues the sides of the corner's cell at its boundary edges to greater vertices.
  void consider_edges_at(SideIndex corner) {
    const std::size_t base = corner / 4 * 4;
    const VertexIndex v = complex_.vertex(corner);
    for (std::size_t s = corner + 1; s < base + 4 && complex_.vertex(s) < complex_.points(); ++s) {
      if (edges_[numbering_.find(v, complex_.vertex(s))].uses() != 1) continue;
      for (std::size_t side = base; side < base + 4; ++side) {
        if (side != corner && side != s) consider_again(SideIndex(side));
      }
    }
  }

  /// The three conditions of Algorithm 1.
  bool wanted(const Listed& facet) {
    for (const EdgeIndex e : facet.edges) {
      if (edges_[e].uses() == 1) return true;
    }
    const auto [a, b, c] = facet.vertices;
    if (!connected_) return used_[a] == 0 || used_[b] == 0 || used_[c] == 0;
    const std::uint32_t root = trees_.find(a);
    return trees_.find(b) != root || trees_.find(c) != root;
  }

  void reject(const Listed& facet) {
    cells_[facet.side / 4].reject(facet.side % 4);
    const SideIndex mate = complex_.mate(facet.side);
    cells_[mate / 4].reject(mate % 4);
    for (const EdgeIndex e : facet.edges) edges_[e].wait();
  }

  void accept(const Listed& facet) {
    cells_[facet.side / 4].choose(facet.side % 4);
    const SideIndex mate = complex_.mate(facet.side);
    cells_[mate / 4].choose(mate % 4);
    ++size_;
    for (const VertexIndex v : facet.vertices) {
      if (connected_) {
        if (trees_.unite(facet.vertices[0], v)) --tree_count_;
      } else if (used_[v] == 0) {
        used_[v] = 1;
        --unused_;
      }
    }
    for (std::size_t j = 0; j < 3; ++j) count_use(facet, j);
  }

  /// One more facet at the edge that lacks the facet's vertex j.
  void count_use(const Listed& facet, std::size_t j) {
    EdgeByte& edge = edges_[facet.edges[j]];
    const unsigned before = edge.uses();
    if (before >= 2) return;
    edge.count_use();
    boundary_edges_ += before == 0 ? 1 : -1;
    if (before == 0 && (closing_ || edge.waited_for())) visit_facets_around(facet.side, facet.vertices[j]);
  }

  /// Turns from the side about its edge that lacks the vertex, through all cells there.
  void visit_facets_around(SideIndex side, VertexIndex behind) {
    for (SideIndex entry = side;;) {
      std::size_t s = entry / 4 * 4;
      while (complex_.vertex(s) != behind) ++s;
      consider_again(SideIndex(s));
      // The next cell's way out is opposite the vertex that this cell's way in was opposite to.
      behind = complex_.vertex(entry);
      entry = complex_.mate(s);
      if (entry == side) return;
    }
  }

  /// Queues a facet that got a boundary edge after it had been passed over.
  void consider_again(SideIndex side) {
    CellByte& cell = cells_[side / 4];
    const bool rejected = cell.rejected(side % 4);
    if (!(rejected || closing_) || cell.chosen(side % 4)) return;
    const Vertices vertices = complex_.facet(side);
    if (vertices[2] == complex_.points()) return;
    if (rejected) {
      const SideIndex mate = complex_.mate(side);
      cell.forget(side % 4);
      cells_[mate / 4].forget(mate % 4);
      ++reinserted_;
    }
    again_.push({criterion_.squares(vertices), vertices, side});
  }

  const DelaunayComplex& complex_;
  const Criterion& criterion_;
  bool connected_;
  EdgeNumbering numbering_;
  std::vector<EdgeByte> edges_;
  std::vector<CellByte> cells_;
  std::vector<Listed> block_;
  std::size_t size_ = 0;
  std::size_t reinserted_ = 0;
  UnionFind trees_;
  std::size_t tree_count_;
  std::vector<std::uint8_t> used_;
  std::size_t unused_;
  std::ptrdiff_t boundary_edges_ = 0;
  bool closing_ = false;
  std::priority_queue<Returning> again_;
};

}  // namespace

Result<BoundaryComplex> boundary_complex(const DelaunayComplex& complex, const Criterion& criterion, bool connected,
                                         Context& context, const std::function<void(unsigned threads)>& meanwhile) {
  const unsigned threads = context.threads();
  FacetQueue queue(complex, criterion, threads);
  Builder builder(complex, criterion, connected, threads);
  bool finished = false;
  parallel_tasks(threads, meanwhile ? 2 : 1, [&](std::size_t task) {
    if (task == 0) {
      finished = builder.run(queue, context);
    } else {
      meanwhile(std::max(threads, 2U) - 1);
    }
  });
  if (!finished) return Error{ErrorCode::cancelled, "cancelled while building the boundary complex"};
  return builder.result();
}

}  // namespace surfaced::boundary
