// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/bodies.hpp"

#include <algorithm>
#include <vector>

#include "base/union_find.hpp"

namespace surfaced::boundary {
namespace {

/// Parts nearer than this many spacings are one body.
constexpr double kBridge = 1.5;
/// A body has at least so many points, and so large a part of all.
constexpr std::size_t kFewestPoints = 12;
constexpr std::size_t kSmallestPart = 1000;
/// Open edges for each point up to which the guiding surface counts as closed.
constexpr double kOpenEdges = 0.01;

std::size_t groups_of(UnionFind& parts, const std::vector<std::uint8_t>& used) {
  std::vector<std::size_t> sizes(used.size(), 0);
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] != 0) ++sizes[parts.find(v)];
  }
  const std::size_t least = std::max(kFewestPoints, used.size() / kSmallestPart);
  return static_cast<std::size_t>(std::ranges::count_if(sizes, [&](std::size_t n) { return n >= least; }));
}

}  // namespace

std::size_t count_bodies(const DelaunayComplex& complex, const GuidingSurface& guide) {
  const std::size_t n = complex.points();
  if (static_cast<double>(guide.open_edges) > kOpenEdges * static_cast<double>(n)) return 1;
  UnionFind parts(n);
  std::vector<std::uint8_t> used(n, 0);
  std::vector<double> lengths(n, 0);
  std::vector<unsigned> edges(n, 0);
  for (const Triangle& t : guide.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexIndex a = t[i];
      const VertexIndex b = t[(i + 1) % 3];
      parts.unite(a, b);
      used[a] = 1;
      const double length = norm(complex.positions[b] - complex.positions[a]);
      lengths[a] += length;
      lengths[b] += length;
      ++edges[a];
      ++edges[b];
    }
  }
  if (groups_of(parts, used) < 2) return 1;
  const auto spacing = [&](VertexIndex v) { return edges[v] == 0 ? 0 : lengths[v] / edges[v]; };
  UnionFind bodies = parts;
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    if (complex.infinite(CellIndex(c))) continue;
    for (const auto& [i, j] : kCellEdges) {
      const VertexIndex a = complex.vertex(4 * c + i);
      const VertexIndex b = complex.vertex(4 * c + j);
      if (used[a] == 0 || used[b] == 0 || parts.find(a) == parts.find(b)) continue;
      const double gap = norm(complex.positions[b] - complex.positions[a]);
      if (gap < kBridge * std::max(spacing(a), spacing(b))) bodies.unite(a, b);
    }
  }
  return std::max<std::size_t>(1, groups_of(bodies, used));
}

}  // namespace surfaced::boundary
