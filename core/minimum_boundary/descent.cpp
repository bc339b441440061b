// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/descent.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <queue>

#include "base/parallel.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kDescentStride = 1024;

bool vertex_touches(const Labelling& labels, VertexIndex v, bool in) {
  return std::ranges::any_of(labels.complex().star(v),
                             [&](SideIndex corner) { return labels.in(DelaunayComplex::cell_of(corner)) == in; });
}

/// Whether a cell with the given label contains the edge of local vertices a and b of cell c.
bool edge_touches(const Labelling& labels, CellIndex c, unsigned a, unsigned b, bool in) {
  for (EdgeWalk walk(labels.complex(), c, a, b);;) {
    if (labels.in(walk.cell()) == in) return true;
    walk.advance();
    if (walk.cell() == c) return false;
  }
}

enum class Kind : std::uint8_t { expose, flip };

struct Move {
  Kind kind;
  std::int64_t change;
  CellIndex cell;
  /// Exposing comes first, then the largest gain, then the lesser cell.
  friend bool operator<(const Move& a, const Move& b) {
    if (a.kind != b.kind) return a.kind > b.kind;
    return a.change != b.change ? a.change > b.change : a.cell > b.cell;
  }
};

class Descender {
 public:
  Descender(Labelling& labels, const Criterion& criterion)
      : labels_(labels), complex_(labels.complex()), criterion_(criterion) {}

  Result<Descent> run(const Context& context, unsigned threads) {
    collect(threads);
    for (std::size_t steps = 1; !queue_.empty(); ++steps) {
      if (steps % kDescentStride == 0 && context.cancelled()) {
        return Error{ErrorCode::cancelled, "cancelled in the final descent"};
      }
      const Move best = queue_.top();
      queue_.pop();
      // An entry whose surroundings changed since was offered again with its new gain.
      Move now{};
      if (!improving(best.cell, now) || now.kind != best.kind || now.change != best.change) continue;
      labels_.flip(best.cell);
      ++(best.kind == Kind::expose ? result_.exposed : result_.flipped);
      offer_around(best.cell);
    }
    return result_;
  }

 private:
  /// Whether flipping the cell is legal and an improvement.
  bool improving(CellIndex c, Move& move) const {
    // Without a call of popcount, which is slow where the machine's instruction is not assumed.
    constexpr std::array<std::uint8_t, 16> kBits{0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
    const unsigned shown = kBits[labels_.border(c)];
    if (shown != 1 && shown != 2) return false;
    if (shown == 1 && !labels_.in(c)) return false;
    if (complex_.infinite(c)) return false;
    move = {shown == 1 ? Kind::expose : Kind::flip, energy_change(labels_, criterion_, c), c};
    return (shown == 1 || move.change < 0) && flip_is_legal(labels_, c);
  }

  void offer(CellIndex c) {
    Move move{};
    if (improving(c, move)) queue_.push(move);
  }

  void collect(unsigned threads) {
    std::vector<std::uint8_t> wanted(complex_.cells(), 0);
    parallel_ranges(threads, complex_.cells(), [&](std::size_t begin, std::size_t end) {
      Move unused{};
      for (std::size_t c = begin; c < end; ++c) wanted[c] = improving(CellIndex(c), unused) ? 1 : 0;
    });
    for (std::size_t c = 0; c < wanted.size(); ++c) {
      if (wanted[c] != 0) offer(CellIndex(c));
    }
  }

  /// A flip matters to the cells that share an edge with the cell: its four neighbours, which share three, and
  /// others, which share one.
  void offer_around(CellIndex c) {
    offer(c);
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) offer(complex_.neighbour(SideIndex(s)));
    for (const auto& [a, b] : kCellEdges) {
      EdgeWalk walk(complex_, c, a, b);
      walk.advance();
      for (walk.advance(); complex_.neighbour(walk.exit()) != c && walk.cell() != c; walk.advance()) {
        offer(walk.cell());
      }
    }
  }

  Labelling& labels_;
  const DelaunayComplex& complex_;
  const Criterion& criterion_;
  std::priority_queue<Move> queue_;
  Descent result_;
};

}  // namespace

std::int64_t energy_change(const Labelling& labels, const Criterion& criterion, CellIndex c) {
  std::int64_t change = 0;
  const std::array<std::int64_t, 4> energies = criterion.energies(c);
  for (std::size_t i = 0; i < 4; ++i) change += labels.on_border(SideIndex(4 * c + i)) ? -energies[i] : energies[i];
  return change;
}

bool flip_is_legal(const Labelling& labels, CellIndex c) {
  const unsigned border = labels.border(c);
  const bool other = !labels.in(c);
  if (std::popcount(border) == 1) {
    return !vertex_touches(labels, labels.complex().vertex(4 * c + static_cast<std::size_t>(std::countr_zero(border))),
                           other);
  }
  if (std::popcount(border) != 2) return false;
  // The facets opposite i and j share the edge of the other two; the edge (i, j) is the opposite one.
  const auto i = static_cast<unsigned>(std::countr_zero(border));
  const auto j = static_cast<unsigned>(std::bit_width(border) - 1);
  return !edge_touches(labels, c, i, j, other);
}

Result<Descent> descend(Labelling& labels, const Criterion& criterion, const Context& context, unsigned threads) {
  return Descender(labels, criterion).run(context, threads);
}

}  // namespace surfaced::boundary
