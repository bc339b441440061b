// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/fusing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/union_find.hpp"

namespace surfaced::boundary {
namespace {

constexpr double kInterior = Judge::kInterior;

/// Cells in which the labellings differ, sorted by region, then by cell.
std::vector<std::pair<std::uint32_t, CellIndex>> differences(const Labelling& a, const Labelling& b) {
  const DelaunayComplex& complex = a.complex();
  UnionFind regions(complex.points());
  std::vector<std::pair<std::uint32_t, CellIndex>> cells;
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    if (a.in(CellIndex(c)) == b.in(CellIndex(c))) continue;
    cells.emplace_back(0, CellIndex(c));
    for (std::size_t i = 1; i < 4; ++i) regions.unite(complex.vertex(4 * c), complex.vertex(4 * c + i));
  }
  for (auto& [region, c] : cells) region = regions.find(complex.vertex(4 * c));
  std::ranges::sort(cells);
  return cells;
}

class Fuser {
 public:
  Fuser(Labelling& labels, const Labelling& other, const Criterion& criterion, bool one_component, Handles& handles,
        SurfaceSearch& search)
      : labels_(labels),
        other_(other),
        complex_(labels.complex()),
        criterion_(criterion),
        one_component_(one_component),
        handles_(handles),
        search_(search) {}

  Fused run() {
    const auto cells = differences(labels_, other_);
    for (std::size_t begin = 0, end = 0; begin < cells.size(); begin = end) {
      region_.clear();
      for (end = begin; end < cells.size() && cells[end].first == cells[begin].first; ++end) {
        region_.push_back(cells[end].second);
      }
      ++fused_.regions;
      if (take_if_better()) ++fused_.taken;
    }
    return fused_;
  }

 private:
  /// Flips the region if that is an improvement.
  bool take_if_better() {
    collect_vertices();
    const auto [gain, euler_change] = score_of_flip();
    if (gain >= 0 && !one_component_ && euler_change == 0) return false;
    const std::size_t before = search_.components(labels_, vertices_);
    if (gain >= 0 && before < 2 && euler_change == 0) return false;
    flip();
    const std::size_t after = search_.components(labels_, vertices_);
    if (euler_change != 0 && after == before) fused_.margin = std::min(fused_.margin, std::abs(gain));
    const double bounty = one_component_ ? Judge::component_price(complex_.points()) : 0;
    const bool better = after <= before && gain < bounty * static_cast<double>(before - after);
    if (better) {
      handles_.now += static_cast<std::int64_t>(after) - static_cast<std::int64_t>(before) - euler_change / 2;
    } else {
      flip();
    }
    return better;
  }

  void flip() {
    for (const CellIndex c : region_) labels_.flip(c);
  }

  void collect_vertices() {
    vertices_.clear();
    for (const CellIndex c : region_) {
      for (std::size_t i = 4 * c; i < 4 * c + 4; ++i) vertices_.push_back(complex_.vertex(i));
    }
    std::ranges::sort(vertices_);
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
  }

  std::int64_t interior_count() const {
    return std::ranges::count_if(vertices_, [&](VertexIndex v) { return labels_.state(v) == VertexState::interior; });
  }

  struct Gain {
    double score;
    std::int64_t euler;
  };

  /// A facet of the region changes its place if only one of its cells is flipped.
  Gain score_of_flip() {
    std::int64_t energy_change = 0;
    std::int64_t energy_sum = 0;
    std::int64_t facet_change = 0;
    std::int64_t facets = 0;
    for (const CellIndex c : region_) {
      for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
        const CellIndex beyond = complex_.neighbour(SideIndex(s));
        if (labels_.in(beyond) != other_.in(beyond)) continue;
        const std::int64_t energy = criterion_.energy(SideIndex(s));
        const bool leaves = labels_.on_border(SideIndex(s));
        energy_change += leaves ? -energy : energy;
        facet_change += leaves ? -1 : 1;
        energy_sum += energy;
        ++facets;
      }
    }
    const std::int64_t interior_before = interior_count();
    flip();
    const std::int64_t interior_change = interior_count() - interior_before;
    flip();
    const double mean = static_cast<double>(std::max<std::int64_t>(1, energy_sum)) / static_cast<double>(facets);
    const std::int64_t euler_change = -interior_change - facet_change / 2;
    return {static_cast<double>(energy_change) / mean + kInterior * static_cast<double>(interior_change) +
                Judge::handle_price(handles_.usual) *
                    static_cast<double>(std::abs(handles_.now - euler_change / 2 - handles_.usual) -
                                        std::abs(handles_.now - handles_.usual)),
            euler_change};
  }

  Labelling& labels_;
  const Labelling& other_;
  const DelaunayComplex& complex_;
  const Criterion& criterion_;
  bool one_component_;
  Handles& handles_;
  SurfaceSearch& search_;
  Fused fused_;
  std::vector<CellIndex> region_;
  std::vector<VertexIndex> vertices_;
};

}  // namespace

Fused fuse(Labelling& labels, const Labelling& other, const Criterion& criterion, bool one_component, Handles& handles,
           SurfaceSearch& search) {
  return Fuser(labels, other, criterion, one_component, handles, search).run();
}

}  // namespace surfaced::boundary
