// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/repair.hpp"

#include <algorithm>

#include "base/parallel.hpp"
#include "minimum_boundary/descent.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kRepairStride = 256;
/// Stars beyond this size are not searched again after every turn: on a fan of thousands of cells that would be
/// quadratic. Inflating mends what is missed.
constexpr std::size_t kLargeStar = 256;

/// Facet-connected components of cells with the same label.
struct CellParts {
  std::vector<std::uint32_t> part_of;
  /// Cells of part p: cells[starts[p]] .. cells[starts[p+1]-1].
  std::vector<CellIndex> cells;
  std::vector<std::size_t> starts{0};
};

CellParts parts_of(const DelaunayComplex& complex, const std::vector<std::uint8_t>& in) {
  constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  CellParts parts{std::vector<std::uint32_t>(in.size(), kNone), {}, {0}};
  parts.cells.reserve(in.size());
  for (std::size_t seed = 0; seed < in.size(); ++seed) {
    if (parts.part_of[seed] != kNone) continue;
    const auto part = static_cast<std::uint32_t>(parts.starts.size() - 1);
    std::size_t next = parts.cells.size();
    parts.part_of[seed] = part;
    parts.cells.emplace_back(seed);
    for (; next < parts.cells.size(); ++next) {
      const CellIndex c = parts.cells[next];
      for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
        const CellIndex other = complex.neighbour(SideIndex(s));
        if (in[other] != in[c] || parts.part_of[other] != kNone) continue;
        parts.part_of[other] = part;
        parts.cells.push_back(other);
      }
    }
    parts.starts.push_back(parts.cells.size());
  }
  return parts;
}

}  // namespace

void clean(const DelaunayComplex& complex, bool islands, std::vector<std::uint8_t>& in) {
  const CellParts parts = parts_of(complex, in);
  const auto cells_of = [&](std::size_t part) {
    return std::span(parts.cells).subspan(parts.starts[part], parts.starts[part + 1] - parts.starts[part]);
  };
  const auto needed_at = [&](CellIndex c, VertexIndex v) {
    return std::ranges::none_of(complex.star(v), [&](SideIndex corner) {
      return in[corner / 4] == in[c] && parts.part_of[corner / 4] != parts.part_of[c];
    });
  };
  for (std::size_t part = 0; part + 1 < parts.starts.size(); ++part) {
    const auto cells = cells_of(part);
    const bool island = in[cells.front()] != 0;
    if (island && !islands) continue;
    const bool stays = std::ranges::any_of(cells, [&](CellIndex c) {
      if (complex.infinite(c)) return true;
      return std::any_of(&complex.vertex(4 * c), &complex.vertex(4 * c) + 4,
                         [&](VertexIndex v) { return needed_at(c, v); });
    });
    if (stays) continue;
    for (const CellIndex c : cells) in[c] ^= 1U;
  }
}

Repairer::Repairer(Labelling& labels, const Criterion& criterion, unsigned threads)
    : labels_(labels),
      complex_(labels.complex()),
      criterion_(criterion),
      counter_(complex_),
      defects_(complex_.points(), 0) {
  const std::vector<VertexState> states = states_of(labels, threads);
  for (std::size_t v = 0; v < states.size(); ++v) {
    if (!good(states[v])) defects_[v] = Defects::of(counter_.count(labels_, VertexIndex(v)));
  }
}

int Repairer::defect_now(VertexIndex v) { return good(labels_.state(v)) ? 0 : Defects::of(counter_.count(labels_, v)); }

std::vector<std::uint8_t> Repairer::good_vertices() const {
  std::vector<std::uint8_t> good(defects_.size());
  for (std::size_t v = 0; v < good.size(); ++v) good[v] = defects_[v] == 0 ? 1 : 0;
  return good;
}

void Repairer::turn(CellIndex c) {
  labels_.flip(c);
  journal_.push_back(c);
  for (std::size_t i = 4 * c; i < 4 * c + 4; ++i) defects_[complex_.vertex(i)] = defect_now(complex_.vertex(i));
}

void Repairer::roll_back() {
  for (const CellIndex c : journal_) labels_.flip(c);
  for (const CellIndex c : journal_) {
    for (std::size_t i = 4 * c; i < 4 * c + 4; ++i) defects_[complex_.vertex(i)] = defect_now(complex_.vertex(i));
  }
  journal_.clear();
}

bool Repairer::improving(CellIndex c, Turn& turn) {
  if (complex_.infinite(c) || std::ranges::find(frozen_, c) != frozen_.end()) return false;
  int before = 0;
  for (std::size_t i = 4 * c; i < 4 * c + 4; ++i) before += defects_[complex_.vertex(i)];
  if (before == 0) return false;
  labels_.flip(c);
  int after = 0;
  for (std::size_t i = 4 * c; i < 4 * c + 4 && after < before; ++i) after += defect_now(complex_.vertex(i));
  labels_.flip(c);
  if (after >= before) return false;
  turn = {after - before, energy_change(labels_, criterion_, c), c};
  return true;
}

void Repairer::offer_star(VertexIndex v) {
  Turn turn{};
  for (const SideIndex corner : complex_.star(v)) {
    if (improving(DelaunayComplex::cell_of(corner), turn)) queue_.push(turn);
  }
}

/// Cells that share a vertex with the cell: their gain may have changed.
void Repairer::offer_neighbours_of(CellIndex c) {
  Turn turn{};
  for (std::size_t i = 4 * c; i < 4 * c + 4; ++i) {
    if (complex_.star(complex_.vertex(i)).size() <= kLargeStar) {
      offer_star(complex_.vertex(i));
    } else if (improving(complex_.neighbour(SideIndex(i)), turn)) {
      queue_.push(turn);
    }
  }
}

bool Repairer::repair_all(const Context& context) {
  for (std::size_t v = 0; v < defects_.size(); ++v) {
    if (defects_[v] != 0) offer_star(VertexIndex(v));
  }
  Turn now{};
  for (std::size_t steps = 1; !queue_.empty(); ++steps) {
    if (steps % kRepairStride == 0 && context.cancelled()) return false;
    const Turn best = queue_.top();
    queue_.pop();
    if (!improving(best.cell, now) || now.defect != best.defect || now.energy != best.energy) continue;
    turn(best.cell);
    offer_neighbours_of(best.cell);
  }
  journal_.clear();
  return true;
}

bool Repairer::repair_around(std::span<const VertexIndex> vertices, std::span<const CellIndex> frozen,
                             std::size_t most) {
  frozen_ = frozen;
  queue_ = {};
  for (const VertexIndex v : vertices) {
    if (v < complex_.points() && defects_[v] != 0) offer_star(v);
  }
  const std::size_t limit = journal_.size() + most;
  Turn now{};
  while (!queue_.empty() && journal_.size() < limit) {
    const Turn best = queue_.top();
    queue_.pop();
    if (!improving(best.cell, now) || now.defect != best.defect || now.energy != best.energy) continue;
    turn(best.cell);
    offer_neighbours_of(best.cell);
  }
  frozen_ = {};
  return std::ranges::all_of(journal_, [&](CellIndex c) {
    return std::all_of(&complex_.vertex(4 * c), &complex_.vertex(4 * c) + 4,
                       [&](VertexIndex v) { return defects_[v] == 0; });
  });
}

}  // namespace surfaced::boundary
