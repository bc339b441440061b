// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/sculpturing.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <queue>

#include "minimum_boundary/descent.hpp"

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

/// IN cells that are connected without crossing a wall.
class Spaces {
 public:
  explicit Spaces(const Walls& walls) : walls_(walls), space_of_(walls.complex().cells(), kNone) {
    const DelaunayComplex& complex = walls.complex();
    std::vector<CellIndex> stack;
    for (std::size_t seed = 0; seed < space_of_.size(); ++seed) {
      if (space_of_[seed] != kNone || !walls.labels.in(CellIndex(seed))) continue;
      space_of_[seed] = count_;
      stack.assign(1, CellIndex(seed));
      while (!stack.empty()) {
        const CellIndex c = stack.back();
        stack.pop_back();
        for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
          const CellIndex beyond = complex.neighbour(SideIndex(s));
          if (walls.contains(SideIndex(s)) || space_of_[beyond] != kNone) continue;
          space_of_[beyond] = count_;
          stack.push_back(beyond);
        }
      }
      ++count_;
    }
  }

  /// The inside hull: every space across the single umbrella of a vertex that also meets the outside; where
  /// there is none, the largest space unless it is a single cell.
  std::vector<std::uint8_t> core() const {
    const DelaunayComplex& complex = walls_.complex();
    std::vector<std::uint8_t> chosen(count_, 0);
    WalledStar star(complex);
    for (std::size_t v = 0; v < complex.points(); ++v) {
      const auto& groups = star.groups(walls_, VertexIndex(v));
      if (groups.size() != 2 || groups[0].outside == groups[1].outside) continue;
      chosen[space_of_[groups[groups[0].outside ? 1 : 0].cells.front()]] = 1;
    }
    if (std::ranges::count(chosen, 1) == 0) choose_largest(chosen);
    std::vector<std::uint8_t> core(space_of_.size(), 0);
    for (std::size_t c = 0; c < core.size(); ++c) {
      if (space_of_[c] != kNone) core[c] = chosen[space_of_[c]];
    }
    return core;
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  void choose_largest(std::vector<std::uint8_t>& chosen) const {
    std::vector<double> volume(count_, 0);
    std::vector<std::size_t> cells(count_, 0);
    const DelaunayComplex& complex = walls_.complex();
    for (std::size_t c = 0; c < space_of_.size(); ++c) {
      if (space_of_[c] == kNone) continue;
      const auto at = [&](std::size_t i) { return complex.positions[complex.vertex(4 * c + i)]; };
      volume[space_of_[c]] += std::abs(dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))));
      ++cells[space_of_[c]];
    }
    const auto largest = std::ranges::max_element(volume);
    if (largest == volume.end()) return;
    const auto index = static_cast<std::size_t>(largest - volume.begin());
    if (cells[index] > 1) chosen[index] = 1;
  }

  const Walls& walls_;
  std::vector<std::uint32_t> space_of_;
  std::uint32_t count_ = 0;
};

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
  return Spaces(Walls{labels, walls}).core();
}

Result<Sculptured> sculpture(Labelling& labels, const FacetSet& walls, const Criterion& criterion,
                             const Context& context) {
  return Sculptor(labels, inside_hull(labels, walls), criterion).run(context);
}

}  // namespace surfaced::boundary
