// SPDX-License-Identifier: GPL-3.0-or-later
#include "intrinsic_delaunay/close_sheets.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <queue>
#include <unordered_map>
#include <vector>

#include "base/vectors.hpp"
#include "cloud/cloud.hpp"

namespace surfaced::idt {
namespace {

using Pair = std::array<std::uint32_t, 2>;

/// Cells along an axis: three numbers of a cell fit a key.
constexpr std::int64_t kMostCells = std::int64_t{1} << 20;

using CellPlace = std::array<std::int64_t, 3>;

struct Cell {
  CellPlace place{};
  /// Ascending.
  std::vector<std::uint32_t> vertices;
  /// All normals are within `angle` of the axis.
  Point3 axis{};
  double angle = std::numbers::pi;
};

std::uint64_t key_of(const CellPlace& p) {
  std::uint64_t key = 0;
  for (const std::int64_t x : p) key = key << 21U | static_cast<std::uint64_t>(x + 1);
  return key;
}

double angle_between(const Point3& a, const Point3& b) { return std::atan2(norm(cross(a, b)), dot(a, b)); }

class SheetFinder {
 public:
  SheetFinder(std::span<const Point3> positions, std::span<const Point3> normals, const Adjacency& adjacency,
              double epsilon, std::size_t most_steps)
      : positions_(positions), normals_(normals), adjacency_(adjacency), reach_(2 * epsilon), budget_(most_steps) {}

  std::optional<Pair> run() {
    sort_into_cells();
    for (const Cell& cell : cells_) look_around(cell);
    return least_;
  }

 private:
  void sort_into_cells() {
    const Bounds bounds = bounds_of({positions_.begin(), positions_.end()});
    const double size =
        std::max(reach_, std::ranges::max(bounds.high - bounds.low) / static_cast<double>(kMostCells - 1));
    for (std::size_t v = 0; v < positions_.size(); ++v) {
      CellPlace place{};
      for (std::size_t i = 0; i < 3; ++i) {
        place.at(i) = static_cast<std::int64_t>(std::floor((positions_[v][i] - bounds.low[i]) / size));
      }
      const auto [found, fresh] = number_.try_emplace(key_of(place), cells_.size());
      if (fresh) cells_.push_back({.place = place, .vertices = {}});
      cells_[found->second].vertices.push_back(static_cast<std::uint32_t>(v));
    }
    for (Cell& cell : cells_) bound_normals(cell);
  }

  void bound_normals(Cell& cell) const {
    Point3 sum{};
    for (const std::uint32_t v : cell.vertices) {
      if (const auto direction = direction_of(normals_[v])) sum += *direction;
    }
    const auto axis = direction_of(sum);
    if (!axis) return;
    cell.axis = *axis;
    cell.angle = 0;
    for (const std::uint32_t v : cell.vertices) {
      if (dot(normals_[v], normals_[v]) > 0) cell.angle = std::max(cell.angle, angle_between(*axis, normals_[v]));
    }
  }

  /// Whether a normal of one may differ by more than 90° from one of the other.
  static bool may_oppose(const Cell& a, const Cell& b) {
    return angle_between(a.axis, b.axis) + a.angle + b.angle > std::numbers::pi / 2;
  }

  void look_around(const Cell& cell) {
    for (std::int64_t x = -1; x <= 1; ++x) {
      for (std::int64_t y = -1; y <= 1; ++y) {
        for (std::int64_t z = -1; z <= 1; ++z) {
          const auto found = number_.find(key_of({cell.place[0] + x, cell.place[1] + y, cell.place[2] + z}));
          if (found != number_.end() && may_oppose(cell, cells_[found->second])) compare(cell, cells_[found->second]);
        }
      }
    }
  }

  void compare(const Cell& a, const Cell& b) {
    for (const std::uint32_t v : a.vertices) {
      for (const std::uint32_t w : b.vertices) {
        if (w <= v || (least_ && *least_ <= Pair{v, w})) continue;
        if (budget_ == 0) return;
        --budget_;
        const double distance = norm(positions_[w] - positions_[v]);
        if (distance > reach_ || !(dot(normals_[v], normals_[w]) < 0)) continue;
        // With curvature 1/(8ε), turning by 90° takes 4πε: 2π times the distance, which is at most 2ε.
        if (near_on_the_mesh(v, w, 2 * std::numbers::pi * distance) == Near::no) least_ = Pair{v, w};
      }
    }
  }

  enum class Near : std::uint8_t { no, yes, unknown };

  /// Whether a path of edges no longer than the limit leads from v to w.
  Near near_on_the_mesh(std::uint32_t v, std::uint32_t w, double limit) {
    using Reached = std::pair<double, std::uint32_t>;
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
    std::unordered_map<std::uint32_t, double> nearest{{v, 0}};
    queue.emplace(0, v);
    while (!queue.empty()) {
      if (budget_ == 0) return Near::unknown;
      --budget_;
      const auto [distance, at] = queue.top();
      queue.pop();
      if (at == w) return Near::yes;
      if (distance > nearest.at(at)) continue;
      for (const std::uint32_t next : adjacency_.of(at)) {
        const double far = distance + norm(positions_[next] - positions_[at]);
        if (far > limit) continue;
        const auto [known, fresh] = nearest.try_emplace(next, far);
        if (!fresh && known->second <= far) continue;
        known->second = far;
        queue.emplace(far, next);
      }
    }
    return Near::no;
  }

  std::span<const Point3> positions_;
  std::span<const Point3> normals_;
  const Adjacency& adjacency_;
  double reach_;
  std::size_t budget_;
  std::vector<Cell> cells_;
  std::unordered_map<std::uint64_t, std::size_t> number_;
  std::optional<Pair> least_;
};

}  // namespace

std::optional<Pair> close_sheets(std::span<const Point3> positions, std::span<const Point3> normals,
                                 const Adjacency& adjacency, double epsilon, std::size_t most_steps) {
  if (positions.size() < 3 || !(epsilon > 0)) return std::nullopt;
  return SheetFinder(positions, normals, adjacency, epsilon, most_steps).run();
}

}  // namespace surfaced::idt
