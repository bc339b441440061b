// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/spaces.hpp"

namespace surfaced::boundary {
namespace {

void flood(const Walls& walls, CellIndex seed, Spaces& spaces, std::vector<CellIndex>& stack) {
  const DelaunayComplex& complex = walls.complex();
  spaces.of_cell[seed] = spaces.count;
  stack.assign(1, seed);
  while (!stack.empty()) {
    const CellIndex c = stack.back();
    stack.pop_back();
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
      const CellIndex beyond = complex.neighbour(SideIndex(s));
      if (walls.contains(SideIndex(s)) || spaces.of_cell[beyond] != Spaces::kOutside) continue;
      spaces.of_cell[beyond] = spaces.count;
      stack.push_back(beyond);
    }
  }
  ++spaces.count;
}

}  // namespace

Spaces find_spaces(const Walls& walls) {
  const DelaunayComplex& complex = walls.complex();
  Spaces spaces;
  spaces.of_cell.assign(complex.cells(), Spaces::kOutside);
  std::vector<CellIndex> stack;
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    if (walls.labels.in(CellIndex(c)) && spaces.of_cell[c] == Spaces::kOutside)
      flood(walls, CellIndex(c), spaces, stack);
  }
  spaces.inside.assign(spaces.count, 0);
  WalledStar star(complex);
  for (std::size_t v = 0; v < complex.points(); ++v) {
    const auto& groups = star.groups(walls, VertexIndex(v));
    if (groups.size() != 2 || groups[0].outside == groups[1].outside) continue;
    spaces.inside[spaces.of_cell[groups[groups[0].outside ? 1 : 0].cells.front()]] = 1;
  }
  return spaces;
}

}  // namespace surfaced::boundary
