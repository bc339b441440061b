// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/measures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
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

Sheets sheets_of(const Labelling& labels, const Criterion& criterion) {
  constexpr double kLong = 10;
  constexpr std::size_t kPartsAtMost = 100;
  const DelaunayComplex& complex = labels.complex();
  std::vector<double> spacing(complex.points(), INFINITY);
  std::vector<std::array<VertexIndex, 3>> facets;
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (!labels.in(CellIndex(s / 4)) || !labels.on_border(SideIndex(s))) continue;
    const auto facet = complex.facet(SideIndex(s));
    facets.push_back(facet);
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexIndex a = facet[i];
      const VertexIndex b = facet[(i + 1) % 3];
      const double squared = criterion.edge_squared(std::min(a, b), std::max(a, b));
      spacing[a] = std::min(spacing[a], squared);
      spacing[b] = std::min(spacing[b], squared);
    }
  }
  double area = 0;
  double sheets = 0;
  UnionFind parts(complex.points());
  for (const auto& [a, b, c] : facets) {
    const Point3 u = complex.positions[b] - complex.positions[a];
    const Point3 v = complex.positions[c] - complex.positions[a];
    const double size = norm(cross(u, v));
    const double longest =
        std::max({criterion.edge_squared(a, b), criterion.edge_squared(a, c), criterion.edge_squared(b, c)});
    area += size;
    if (longest > kLong * kLong * std::max({spacing[a], spacing[b], spacing[c]})) {
      sheets += size;
    } else {
      parts.unite(a, b);
      parts.unite(a, c);
    }
  }
  std::vector<std::size_t> sizes(complex.points(), 0);
  for (std::size_t v = 0; v < sizes.size(); ++v) ++sizes[parts.find(v)];
  // Points inside and points that only sheets touch are alone.
  const std::size_t least = std::max<std::size_t>(2, complex.points() / kPartsAtMost);
  return {area > 0 ? sheets / area : 0,
          static_cast<std::size_t>(std::ranges::count_if(sizes, [&](std::size_t n) { return n >= least; }))};
}

}  // namespace surfaced::boundary
