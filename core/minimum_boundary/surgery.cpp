// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/surgery.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/parallel.hpp"
#include "minimum_boundary/candidates.hpp"
#include "minimum_boundary/descent.hpp"
#include "minimum_boundary/repair.hpp"

namespace surfaced::boundary {
namespace {

constexpr int kPasses = 3;
constexpr std::size_t kMostTurns = 30;
/// What costs so much more than that is no choice.
constexpr double kOutOfQuestion = 10;

bool edge_on_surface(const Labelling& labels, CellIndex c, unsigned a, unsigned b) {
  for (EdgeWalk walk(labels.complex(), c, a, b);;) {
    if (labels.on_border(walk.exit())) return true;
    walk.advance();
    if (walk.cell() == c) return false;
  }
}

/// Facets between cells of equal label whose three edges lie on the surface.
std::vector<SideIndex> loops_of(const Labelling& labels, unsigned threads) {
  const DelaunayComplex& complex = labels.complex();
  std::vector<std::uint8_t> found(complex.cells(), 0);
  parallel_ranges(threads, complex.cells(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (complex.infinite(CellIndex(c))) continue;
      unsigned edges = 0;
      for (unsigned k = 0; k < 6; ++k) {
        if (edge_on_surface(labels, CellIndex(c), kCellEdges[k][0], kCellEdges[k][1])) edges |= 1U << k;
      }
      // Edges of the facet opposite each vertex.
      constexpr std::array<unsigned, 4> kFacetEdges{0b111000, 0b100110, 0b010101, 0b001011};
      for (unsigned i = 0; i < 4; ++i) {
        const SideIndex side(4 * c + i);
        if ((edges & kFacetEdges[i]) != kFacetEdges[i] || labels.on_border(side)) continue;
        if (side > complex.mate(side) && !complex.infinite(complex.neighbour(side))) continue;
        found[c] |= static_cast<std::uint8_t>(1U << i);
      }
    }
  });
  std::vector<SideIndex> loops;
  for (std::size_t c = 0; c < found.size(); ++c) {
    for (unsigned bits = found[c]; bits != 0; bits &= bits - 1) {
      loops.emplace_back(4 * c + static_cast<std::size_t>(std::countr_zero(bits)));
    }
  }
  return loops;
}

class Surgeon {
 public:
  Surgeon(Labelling& labels, const Criterion& criterion, Handles& handles, SurfaceSearch& search, unsigned threads)
      : labels_(labels),
        complex_(labels.complex()),
        criterion_(criterion),
        handles_(handles),
        search_(search),
        repairer_(labels, criterion, threads) {}

  /// Caps the loop by its two cells, or by one of them.
  std::int64_t cap(SideIndex side) {
    const CellIndex c = DelaunayComplex::cell_of(side);
    const CellIndex d = complex_.neighbour(side);
    if (labels_.on_border(side)) return 0;
    // Three facets shown: the loop runs around a vertex of three triangles, and there is no handle to cut.
    if (std::popcount(labels_.border(c)) == 3 || std::popcount(labels_.border(d)) == 3) return 0;
    std::vector<std::vector<CellIndex>> choices{{c}};
    if (!complex_.infinite(d)) choices = {{c, d}, {c}, {d}};
    for (const auto& cells : choices) {
      if (const std::int64_t gained = attempt(side, cells); gained > 0) return gained;
    }
    return 0;
  }

  double margin() const { return margin_; }

 private:
  struct Change {
    std::int64_t energy = 0;
    std::int64_t facets = 0;
  };

  /// Flips the cells, repairs around them and keeps that if it is worth it; returns the rise of χ.
  std::int64_t attempt(SideIndex side, std::span<const CellIndex> cells) {
    repairer_.clear_journal();
    std::vector<VertexIndex> vertices;
    for (const CellIndex c : cells) {
      repairer_.turn(c);
      vertices.insert(vertices.end(), &complex_.vertex(4 * c), &complex_.vertex(4 * c) + 4);
    }
    if (!repairer_.repair_around(vertices, cells, kMostTurns)) {
      repairer_.roll_back();
      return 0;
    }
    const std::vector<CellIndex> turned = repairer_.journal();
    collect_vertices(turned);
    const std::int64_t interior_after = interior_count();
    repairer_.roll_back();
    const std::int64_t interior_change = interior_after - interior_count();
    Change change;
    for (const CellIndex c : turned) apply(c, change);
    const std::int64_t rise = -interior_change - change.facets / 2;
    const double price = Judge::handle_price(handles_.usual) * (handles_.now > handles_.usual ? 1 : -1);
    const double cost = static_cast<double>(change.energy) / static_cast<double>(criterion_.energy(side));
    if (interior_change > 0 || rise <= 0 || cost > price + kOutOfQuestion || adds_component(turned)) {
      repairer_.roll_back();
      return 0;
    }
    margin_ = std::min(margin_, std::abs(cost - price));
    if (cost < price) {
      handles_.now -= rise / 2;
      return rise;
    }
    repairer_.roll_back();
    return 0;
  }

  /// Whether the surface had fewer components near these cells before they were turned.
  bool adds_component(const std::vector<CellIndex>& turned) {
    const std::size_t after = search_.components(labels_, vertices_);
    for (const CellIndex c : turned) labels_.flip(c);
    const std::size_t before = search_.components(labels_, vertices_);
    for (const CellIndex c : turned) labels_.flip(c);
    return after > before;
  }

  void apply(CellIndex c, Change& change) {
    change.energy += energy_change(labels_, criterion_, c);
    change.facets += 4 - 2 * std::popcount(labels_.border(c));
    repairer_.turn(c);
  }

  void collect_vertices(std::span<const CellIndex> cells) {
    vertices_.clear();
    for (const CellIndex c : cells)
      vertices_.insert(vertices_.end(), &complex_.vertex(4 * c), &complex_.vertex(4 * c) + 4);
    std::ranges::sort(vertices_);
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
  }

  std::int64_t interior_count() const {
    return std::ranges::count_if(vertices_, [&](VertexIndex v) { return labels_.state(v) == VertexState::interior; });
  }

  Labelling& labels_;
  const DelaunayComplex& complex_;
  const Criterion& criterion_;
  Handles& handles_;
  double margin_ = std::numeric_limits<double>::infinity();
  SurfaceSearch& search_;
  Repairer repairer_;
  std::vector<VertexIndex> vertices_;
};

}  // namespace

Result<Surgery> operate(Labelling& labels, const Criterion& criterion, Handles& handles, SurfaceSearch& search,
                        const Context& context, unsigned threads) {
  Surgery surgery;
  Surgeon surgeon(labels, criterion, handles, search, threads);
  for (int pass = 0; pass < kPasses; ++pass) {
    std::int64_t gained = 0;
    for (const SideIndex side : loops_of(labels, threads)) {
      if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled in surgery"};
      ++surgery.loops;
      gained += surgeon.cap(side);
    }
    surgery.removed_handles += static_cast<std::size_t>(gained / 2);
    if (gained == 0) break;
  }
  surgery.margin = surgeon.margin();
  return surgery;
}

}  // namespace surfaced::boundary
