// SPDX-License-Identifier: GPL-3.0-or-later
// Incremental Delaunay triangulation (Bowyer 1981, Watson 1981) in flat arrays.
#include <algorithm>
#include <array>
#include <new>
#include <string>

#include "delaunay/delaunay.hpp"
#include "delaunay/insertion_order.hpp"
#include "delaunay/predicates.hpp"

namespace surfaced {
namespace {

constexpr std::size_t kCancelStride = 1024;
/// Cells per point on most surfaces; only what is used of the reserve is ever touched.
constexpr std::size_t kUsualCells = 7;

using Cell = RawTriangulation::Cell;

class Triangulation {
 public:
  explicit Triangulation(std::span<const Point3> points)
      : points_(points), infinite_(static_cast<std::uint32_t>(points.size())) {
    cells_.reserve(kUsualCells * points.size());
    states_.reserve(kUsualCells * points.size());
  }

  /// Four points of the order that span a volume: swapped to its front. Returns the dimension of the points.
  int begin(std::vector<std::uint32_t>& order) {
    const auto point = [&](std::size_t k) -> const Point3& { return points_[order[k]]; };
    std::size_t third = 2;
    while (third < order.size() && predicates::collinear(point(0), point(1), point(third))) ++third;
    if (third == order.size()) return 1;
    std::swap(order[2], order[third]);
    int side = 0;
    std::size_t fourth = 3;
    while (fourth < order.size() && side == 0) {
      side = predicates::orientation(point(0), point(1), point(2), point(fourth++));
    }
    if (side == 0) return 2;
    std::swap(order[3], order[fourth - 1]);
    make_first_cells({order[0], side > 0 ? order[1] : order[2], side > 0 ? order[2] : order[1], order[3]});
    return 3;
  }

  /// False if there are too many cells.
  bool insert(std::uint32_t v) {
    find_cavity(locate(points_[v]), points_[v]);
    if (cells_.size() + border_.size() > kMostCells) return false;
    fill_cavity(v);
    return true;
  }

  /// The cells without holes between them.
  std::vector<Cell> take() {
    std::ranges::sort(free_);
    while (!free_.empty()) {
      const std::uint32_t hole = free_.back();
      free_.pop_back();
      const auto last = static_cast<std::uint32_t>(cells_.size() - 1);
      if (hole != last) {
        cells_[hole] = cells_[last];
        for (std::uint32_t i = 0; i < 4; ++i) mate_of(cells_[hole].mates[i]) = 4 * hole + i;
      }
      cells_.pop_back();
    }
    return std::move(cells_);
  }

 private:
  /// What the search for the cavity knows about a cell; all are `unseen` between insertions.
  enum class State : std::uint8_t { unseen, conflicting, clear };

  /// A facet between the cavity and the rest, seen from both.
  struct BorderFacet {
    std::uint32_t inner;
    std::uint32_t outer;
  };

  std::uint32_t& mate_of(std::uint32_t side) { return cells_[side / 4].mates[side % 4]; }

  static std::uint32_t slot_of(const Cell& cell, std::uint32_t v) {
    std::uint32_t i = 0;
    while (cell.vertices[i] != v) ++i;
    return i;
  }

  /// Slot of the vertex at infinity, 4 for a finite cell.
  std::uint32_t infinite_slot(const Cell& cell) const {
    std::uint32_t i = 0;
    while (i < 4 && cell.vertices[i] != infinite_) ++i;
    return i;
  }

  void make_first_cells(const std::array<std::uint32_t, 4>& v) {
    cells_.assign(5, Cell{v, {}});
    for (std::uint32_t i = 0; i < 4; ++i) {
      // Beyond facet i the vertex at infinity stands on the other side: two others change places.
      auto& vertices = cells_[i + 1].vertices;
      vertices[i] = infinite_;
      std::swap(vertices[(i + 1) % 4], vertices[(i + 2) % 4]);
    }
    // Any two of the five cells share the facet that lacks the vertices which the other has not.
    for (std::uint32_t c = 0; c < 5; ++c) {
      for (std::uint32_t d = 0; d < 5; ++d) {
        if (c == d) continue;
        const auto lacks = [](const Cell& cell, std::uint32_t u) { return !std::ranges::count(cell.vertices, u); };
        std::uint32_t i = 0;
        while (!lacks(cells_[d], cells_[c].vertices[i])) ++i;
        std::uint32_t j = 0;
        while (!lacks(cells_[c], cells_[d].vertices[j])) ++j;
        cells_[c].mates[i] = 4 * d + j;
      }
    }
    states_.assign(5, State::unseen);
    hint_ = 0;
  }

  /// Sign of the volume of the finite cell with p in place of its vertex i.
  int orientation_with(const Cell& cell, std::size_t i, const Point3& p) const {
    std::array<const Point3*, 4> q;
    for (std::size_t k = 0; k < 4; ++k) q[k] = k == i ? &p : &points_[cell.vertices[k]];
    return predicates::orientation(*q[0], *q[1], *q[2], *q[3]);
  }

  /// A cell in conflict with p: the finite cell that contains it, or an infinite one that sees it. Walks through
  /// facets that part the cell from p, which in a Delaunay triangulation never leads back.
  std::uint32_t locate(const Point3& p) const {
    std::uint32_t c = hint_;
    if (const std::uint32_t i = infinite_slot(cells_[c]); i < 4) c = cells_[c].mates[i] / 4;
    for (std::uint32_t entry = 4;;) {
      const Cell& cell = cells_[c];
      std::uint32_t i = 0;
      while (i < 4 && (i == entry || orientation_with(cell, i, p) >= 0)) ++i;
      if (i == 4) return c;
      c = cell.mates[i] / 4;
      entry = cell.mates[i] % 4;
      if (infinite_slot(cells_[c]) < 4) return c;
    }
  }

  /// Whether p lies in the cell's circumscribed ball; for an infinite cell that is beyond its hull facet.
  bool conflicts(const Cell& cell, const Point3& p) const {
    const std::uint32_t infinite = infinite_slot(cell);
    const auto point = [&](std::size_t i) -> const Point3& { return points_[cell.vertices[i]]; };
    if (infinite == 4) {
      const int side = predicates::side_of_sphere(point(0), point(1), point(2), point(3), p);
      if (side != 0) return side > 0;
      return predicates::perturbed_side_of_sphere({point(0), point(1), point(2), point(3)}, p) > 0;
    }
    const int side = orientation_with(cell, infinite, p);
    if (side != 0) return side > 0;
    // The hull facet as p would see it if it stood beyond.
    constexpr std::array<std::array<std::uint8_t, 3>, 4> kFacet{{{2, 1, 3}, {2, 3, 0}, {0, 3, 1}, {0, 1, 2}}};
    const auto [a, b, c] = kFacet[infinite];
    return predicates::perturbed_side_of_circle({point(a), point(b), point(c)}, p) > 0;
  }

  /// All cells in conflict with p, which are connected, and the facets around them.
  void find_cavity(std::uint32_t first, const Point3& p) {
    cavity_.assign(1, first);
    states_[first] = State::conflicting;
    clear_.clear();
    border_.clear();
    for (std::size_t k = 0; k < cavity_.size(); ++k) {
      const std::uint32_t c = cavity_[k];
      for (const std::uint32_t mate : cells_[c].mates) __builtin_prefetch(&cells_[mate / 4]);
      for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t mate = cells_[c].mates[i];
        State& state = states_[mate / 4];
        if (state == State::unseen) {
          state = conflicts(cells_[mate / 4], p) ? State::conflicting : State::clear;
          (state == State::conflicting ? cavity_ : clear_).push_back(mate / 4);
        }
        if (state == State::clear) border_.push_back({4 * c + i, mate});
      }
    }
  }

  /// Puts cells between v and the facets around the cavity in place of its cells.
  void fill_cavity(std::uint32_t v) {
    for (const auto& [inner, outer] : border_) {
      std::uint32_t made = 0;
      if (free_.empty()) {
        made = static_cast<std::uint32_t>(cells_.size());
        cells_.emplace_back();
        states_.push_back(State::unseen);
      } else {
        made = free_.back();
        free_.pop_back();
      }
      // The old cell with v in place of the vertex opposite the facet.
      Cell& cell = cells_[made];
      cell.vertices = cells_[inner / 4].vertices;
      cell.vertices[inner % 4] = v;
      cell.mates.fill(kUnlinked);
      cell.mates[inner % 4] = outer;
      mate_of(outer) = 4 * made + inner % 4;
    }
    for (const auto& [inner, outer] : border_) link(inner, mate_of(outer) / 4);
    for (const std::uint32_t c : clear_) states_[c] = State::unseen;
    for (const std::uint32_t c : cavity_) states_[c] = State::unseen;
    hint_ = mate_of(border_.back().outer) / 4;
    free_.insert(free_.end(), cavity_.begin(), cavity_.end());
  }

  /// Joins a new cell to those beyond the three edges of its facet: turns about each edge through the old cells
  /// of the cavity, which are still there, to the next facet around it.
  void link(std::uint32_t inner, std::uint32_t made) {
    for (std::uint32_t j = 0; j < 4; ++j) {
      if (cells_[made].mates[j] != kUnlinked) continue;
      std::uint32_t entry = inner;
      std::uint32_t exit = inner / 4 * 4 + j;
      std::uint32_t beyond = mate_of(exit);
      while (states_[beyond / 4] == State::conflicting) {
        const std::uint32_t behind = cells_[entry / 4].vertices[entry % 4];
        entry = beyond;
        exit = entry / 4 * 4 + slot_of(cells_[entry / 4], behind);
        beyond = mate_of(exit);
      }
      // `beyond` belongs to the next facet, whose new cell lacks the vertex that `entry` lacks.
      const std::uint32_t other = mate_of(beyond) / 4 * 4 + entry % 4;
      cells_[made].mates[j] = other;
      mate_of(other) = 4 * made + j;
    }
  }

  static constexpr std::uint32_t kUnlinked = 0xFFFFFFFFU;

  std::span<const Point3> points_;
  std::uint32_t infinite_;
  std::vector<Cell> cells_;
  std::vector<State> states_;
  /// Cells that are no longer in use.
  std::vector<std::uint32_t> free_;
  std::uint32_t hint_ = 0;
  std::vector<std::uint32_t> cavity_;
  std::vector<std::uint32_t> clear_;
  std::vector<BorderFacet> border_;
};

Result<RawTriangulation> insert_all(std::span<const Point3> points, Context& context) {
  std::vector<std::uint32_t> order = insertion_order(points.size());
  Triangulation triangulation(points);
  RawTriangulation raw;
  raw.dimension = triangulation.begin(order);
  if (raw.dimension < 3) return raw;
  constexpr std::size_t kFirst = 4;
  for (std::size_t k = kFirst; k < order.size(); ++k) {
    if (k % kCancelStride == kFirst) {
      if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled while triangulating"};
      context.report(static_cast<double>(k) / static_cast<double>(order.size()));
    }
    if (triangulation.insert(order[k])) continue;
    return Error{ErrorCode::too_many_points, "more than " + std::to_string(kMostCells) + " Delaunay cells after " +
                                                 std::to_string(k) + " of " + std::to_string(points.size()) +
                                                 " points"};
  }
  raw.cells = triangulation.take();
  return raw;
}

}  // namespace

Result<RawTriangulation> triangulate(std::span<const Point3> points, Context& context) {
  try {
    return insert_all(points, context);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory,
                 "no memory left while triangulating " + std::to_string(points.size()) + " points"};
  }
}

}  // namespace surfaced
