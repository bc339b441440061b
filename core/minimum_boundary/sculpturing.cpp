// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/sculpturing.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <queue>

#include "minimum_boundary/descent.hpp"
#include "minimum_boundary/spaces.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kSculptStride = 1024;

/// Squared circumradius of a facet, the vertices in ascending order; infinite where it is too thin to tell.
double squared_circumradius(const DelaunayComplex& complex, SideIndex s) {
  const auto [a, b, c] = complex.facet(s);
  const Point3 u = complex.positions[b] - complex.positions[a];
  const Point3 v = complex.positions[c] - complex.positions[a];
  const Point3 w = complex.positions[c] - complex.positions[b];
  const Point3 n = cross(u, v);
  const double squared = dot(u, u) * dot(v, v) * dot(w, w) / (4 * dot(n, n));
  return std::isnan(squared) ? INFINITY : squared;
}

/// Marks the space of largest volume unless it is a single cell.
void choose_largest(const DelaunayComplex& complex, Spaces& spaces) {
  std::vector<double> volume(spaces.count, 0);
  std::vector<std::size_t> cells(spaces.count, 0);
  for (std::size_t c = 0; c < spaces.of_cell.size(); ++c) {
    const std::uint32_t space = spaces.of_cell[c];
    if (space == Spaces::kOutside) continue;
    const auto at = [&](std::size_t i) { return complex.positions[complex.vertex(4 * c + i)]; };
    volume[space] += std::abs(dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))));
    ++cells[space];
  }
  const auto largest = std::ranges::max_element(volume);
  if (largest == volume.end()) return;
  const auto index = static_cast<std::size_t>(largest - volume.begin());
  if (cells[index] > 1) spaces.inside[index] = 1;
}

enum class Taker : std::uint8_t { outside, core };

struct Removal {
  double longest;
  CellIndex cell;
  Taker taker;
  friend bool operator<(const Removal& a, const Removal& b) {
    if (a.longest != b.longest) return a.longest < b.longest;
    return a.cell != b.cell ? a.cell > b.cell : a.taker > b.taker;
  }
};

class Sculptor {
 public:
  Sculptor(Labelling& labels, const std::vector<std::uint8_t>& core, const Criterion& criterion)
      : labels_(labels), core_(labels.complex()), complex_(labels.complex()), criterion_(criterion) {
    core_.assign(core, 1);
    result_.core = static_cast<std::size_t>(std::ranges::count(core, 1));
  }

  Result<Sculptured> run(const Context& context) {
    for (std::size_t c = 0; c < complex_.cells(); ++c) offer(CellIndex(c));
    for (std::size_t steps = 1; !queue_.empty(); ++steps) {
      if (steps % kSculptStride == 0 && context.cancelled()) {
        return Error{ErrorCode::cancelled, "cancelled while sculpturing"};
      }
      const Removal best = queue_.top();
      queue_.pop();
      Removal now{};
      if (!removable(best.cell, best.taker, now) || now.longest != best.longest) continue;
      Labelling& side = best.taker == Taker::outside ? labels_ : core_;
      ++(std::popcount(side.border(best.cell)) == 1 ? result_.exposed : result_.flipped);
      side.flip(best.cell);
      offer_around(best.cell);
    }
    for (std::size_t c = 0; c < complex_.cells(); ++c) result_.left += between(CellIndex(c)) ? 1U : 0U;
    return result_;
  }

 private:
  /// Cells between the outside and the core.
  bool between(CellIndex c) const { return labels_.in(c) && !core_.in(c); }

  bool removable(CellIndex c, Taker taker, Removal& removal) const {
    if (!between(c)) return false;
    const Labelling& side = taker == Taker::outside ? labels_ : core_;
    const unsigned border = side.border(c);
    if (std::popcount(border) != 1 && std::popcount(border) != 2) return false;
    if (removes_smallest(c, border) || !flip_is_legal(side, c)) return false;
    removal = {0, c, taker};
    for (unsigned i = 0; i < 4; ++i) {
      if ((border >> i & 1U) != 0)
        removal.longest = std::max(removal.longest, criterion_.squared(SideIndex(4 * c + i)));
    }
    return true;
  }

  /// §6.3: the facet of least circumradius has to stay.
  bool removes_smallest(CellIndex c, unsigned border) const {
    SideIndex smallest(4 * c);
    double least = squared_circumradius(complex_, smallest);
    for (std::size_t s = 4 * c + 1; s < 4 * c + 4; ++s) {
      const double squared = squared_circumradius(complex_, SideIndex(s));
      if (squared > least || (squared == least && !criterion_.less(SideIndex(s), smallest))) continue;
      smallest = SideIndex(s);
      least = squared;
    }
    return (border >> (smallest % 4) & 1U) != 0;
  }

  void offer(CellIndex c) {
    Removal removal{};
    for (const Taker taker : {Taker::outside, Taker::core}) {
      if (removable(c, taker, removal)) queue_.push(removal);
    }
  }

  /// A removal matters to the cells that share a vertex with the cell.
  void offer_around(CellIndex c) {
    for (std::size_t i = 4 * c; i < 4 * c + 4; ++i) {
      for (const SideIndex corner : complex_.star(complex_.vertex(i))) offer(DelaunayComplex::cell_of(corner));
    }
  }

  Labelling& labels_;
  Labelling core_;
  const DelaunayComplex& complex_;
  const Criterion& criterion_;
  std::priority_queue<Removal> queue_;
  Sculptured result_;
};

}  // namespace

std::vector<std::uint8_t> inside_hull(const Labelling& labels, const FacetSet& walls) {
  Spaces spaces = find_spaces(Walls{labels, walls});
  if (std::ranges::count(spaces.inside, 1) == 0) choose_largest(labels.complex(), spaces);
  std::vector<std::uint8_t> core(spaces.of_cell.size(), 0);
  for (std::size_t c = 0; c < core.size(); ++c) {
    if (spaces.of_cell[c] != Spaces::kOutside) core[c] = spaces.inside[spaces.of_cell[c]];
  }
  return core;
}

Result<Sculptured> sculpture(Labelling& labels, const FacetSet& walls, const Criterion& criterion,
                             const Context& context) {
  return Sculptor(labels, inside_hull(labels, walls), criterion).run(context);
}

}  // namespace surfaced::boundary
