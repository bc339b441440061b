// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/walled_star.hpp"

#include <algorithm>

namespace surfaced::boundary {

const std::vector<WalledStar::Group>& WalledStar::groups(const Walls& walls, VertexIndex v) {
  const DelaunayComplex& complex = walls.complex();
  if (++epoch_ == 0) {
    std::ranges::fill(mark_, 0U);
    epoch_ = 1;
  }
  groups_.clear();
  for (const SideIndex seed : complex.star(v)) {
    if (mark_[seed / 4] == epoch_) continue;
    Group group{!walls.labels.in(CellIndex(seed / 4)), {CellIndex(seed / 4)}};
    mark_[seed / 4] = epoch_;
    for (std::size_t next = 0; next < group.cells.size(); ++next) {
      const CellIndex c = group.cells[next];
      for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
        if (complex.vertex(s) == v || walls.contains(SideIndex(s))) continue;
        const CellIndex beyond = complex.neighbour(SideIndex(s));
        if (mark_[beyond] == epoch_) continue;
        mark_[beyond] = epoch_;
        group.cells.push_back(beyond);
      }
    }
    groups_.push_back(std::move(group));
  }
  return groups_;
}

SideIndex next_hull_side(const Walls& walls, SideIndex side, VertexIndex behind) {
  const DelaunayComplex& complex = walls.complex();
  for (SideIndex entry = side;;) {
    std::size_t exit = entry / 4 * 4;
    while (complex.vertex(exit) != behind) ++exit;
    if (walls.contains(SideIndex(exit))) return SideIndex(exit);
    behind = complex.vertex(entry);
    entry = complex.mate(exit);
  }
}

}  // namespace surfaced::boundary
