// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/hull.hpp"

namespace surfaced::boundary {

std::vector<std::uint8_t> cells_behind(const DelaunayComplex& complex, const FacetSet& walls) {
  std::vector<std::uint8_t> behind(complex.cells(), 1);
  std::vector<CellIndex> stack;
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    if (!complex.infinite(CellIndex(c))) continue;
    behind[c] = 0;
    stack.emplace_back(c);
  }
  while (!stack.empty()) {
    const CellIndex c = stack.back();
    stack.pop_back();
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
      const CellIndex next = complex.neighbour(SideIndex(s));
      if (behind[next] == 0 || walls.contains(SideIndex(s))) continue;
      behind[next] = 0;
      stack.push_back(next);
    }
  }
  return behind;
}

}  // namespace surfaced::boundary
