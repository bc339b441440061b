#include "minimum_boundary/measures.hpp"

#include <vector>

#include "base/union_find.hpp"

namespace surfaced::boundary {

Measures measure(const Labelling& labels, const Criterion& criterion) {
  const DelaunayComplex& complex = labels.complex();
  Measures measures;
  UnionFind parts(complex.points());
  std::vector<std::uint8_t> used(complex.points(), 0);
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    if (!labels.in(CellIndex(c)) || labels.border(CellIndex(c)) == 0) continue;
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
      if (!labels.on_border(SideIndex(s))) continue;
      const auto [p, q, r] = complex.facet(SideIndex(s));
      ++measures.facets;
      measures.energy += criterion.energy(SideIndex(s));
      used[p] = used[q] = used[r] = 1;
      parts.unite(p, q);
      parts.unite(p, r);
    }
  }
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0) continue;
    ++measures.vertices;
    if (parts.find(v) == v) ++measures.components;
  }
  measures.interior = complex.points() - measures.vertices;
  return measures;
}

}  // namespace surfaced::boundary
