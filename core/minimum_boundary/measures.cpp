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
      const auto [p, q, r] = complex.outward_facet(SideIndex(s));
      ++measures.facets;
      measures.energy += criterion.energy(SideIndex(s));
      measures.volume += dot(complex.positions[p], cross(complex.positions[q], complex.positions[r])) / 6;
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

namespace {

constexpr double kLong = 10;
constexpr double kFar = 8;
constexpr std::size_t kPartsAtMost = 100;

double squared_length(const Point3& edge) { return dot(edge, edge); }

/// The square of the shortest edge at each vertex; infinite at points that are not on the surface.
std::vector<double> squared_spacings(const std::vector<Point3>& positions, const std::vector<Triangle>& triangles) {
  std::vector<double> spacing(positions.size(), INFINITY);
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexIndex a = std::min(t[i], t[(i + 1) % 3]);
      const VertexIndex b = std::max(t[i], t[(i + 1) % 3]);
      const double squared = squared_length(positions[b] - positions[a]);
      spacing[a] = std::min(spacing[a], squared);
      spacing[b] = std::min(spacing[b], squared);
    }
  }
  return spacing;
}

bool is_sheet(const std::vector<Point3>& positions, const std::vector<double>& spacing, const Triangle& t) {
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const VertexIndex a = std::min(t[i], t[(i + 1) % 3]);
    const VertexIndex b = std::max(t[i], t[(i + 1) % 3]);
    longest = std::max(longest, squared_length(positions[b] - positions[a]));
  }
  return longest > kLong * kLong * std::max({spacing[t[0]], spacing[t[1]], spacing[t[2]]});
}

std::vector<VertexIndex> far_vertices(const std::vector<Triangle>& triangles, const std::vector<double>& spacing) {
  std::vector<double> around(spacing.size(), 0);
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      around[t[i]] = std::max({around[t[i]], spacing[t[(i + 1) % 3]], spacing[t[(i + 2) % 3]]});
    }
  }
  std::vector<VertexIndex> far;
  for (std::size_t v = 0; v < spacing.size(); ++v) {
    if (std::isfinite(spacing[v]) && spacing[v] > kFar * kFar * around[v]) far.emplace_back(v);
  }
  return far;
}

}  // namespace

std::vector<std::uint8_t> mark_sheets(const std::vector<Point3>& positions, const std::vector<Triangle>& triangles) {
  const std::vector<double> spacing = squared_spacings(positions, triangles);
  std::vector<std::uint8_t> marks(triangles.size());
  for (std::size_t t = 0; t < marks.size(); ++t) marks[t] = is_sheet(positions, spacing, triangles[t]) ? 1 : 0;
  return marks;
}

Sheets sheets_of(const Labelling& labels) {
  const DelaunayComplex& complex = labels.complex();
  std::vector<Triangle> facets;
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (labels.in(CellIndex(s / 4)) && labels.on_border(SideIndex(s))) facets.push_back(complex.facet(SideIndex(s)));
  }
  const std::vector<double> spacing = squared_spacings(complex.positions, facets);
  double area = 0;
  double sheets = 0;
  UnionFind parts(complex.points());
  for (const Triangle& t : facets) {
    const Point3 u = complex.positions[t[1]] - complex.positions[t[0]];
    const Point3 v = complex.positions[t[2]] - complex.positions[t[0]];
    const double size = norm(cross(u, v));
    area += size;
    if (is_sheet(complex.positions, spacing, t)) {
      sheets += size;
    } else {
      parts.unite(t[0], t[1]);
      parts.unite(t[0], t[2]);
    }
  }
  std::vector<std::size_t> sizes(complex.points(), 0);
  for (std::size_t v = 0; v < sizes.size(); ++v) ++sizes[parts.find(v)];
  // Points inside and points that only sheets touch are alone.
  const std::size_t least = std::max<std::size_t>(2, complex.points() / kPartsAtMost);
  return {area > 0 ? sheets / area : 0,
          static_cast<std::size_t>(std::ranges::count_if(sizes, [&](std::size_t n) { return n >= least; })),
          far_vertices(facets, spacing)};
}

}  // namespace surfaced::boundary
