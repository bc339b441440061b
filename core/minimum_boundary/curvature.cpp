#include "minimum_boundary/curvature.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "minimum_boundary/descent.hpp"

namespace surfaced::boundary {
namespace {

class Bending {
 public:
  explicit Bending(Labelling& labels) : labels_(labels), complex_(labels.complex()) {}

  double total() const {
    double sum = 0;
    for (std::size_t s = 0; s < 4 * complex_.cells(); ++s) {
      if (!labels_.in(CellIndex(s / 4)) || !labels_.on_border(SideIndex(s))) continue;
      for (const VertexIndex v : complex_.facet(SideIndex(s))) {
        const SideIndex next = beyond(SideIndex(s), v);
        if (s < next) sum += bend(SideIndex(s), next, v);
      }
    }
    return sum;
  }

  /// Flips the cell if that lowers K; returns by how much.
  double improve(CellIndex c) {
    if (complex_.infinite(c) || std::popcount(labels_.border(c)) != 2 || !flip_is_legal(labels_, c)) return 0;
    const double before = around(c);
    labels_.flip(c);
    const double after = around(c);
    if (after < before) return before - after;
    labels_.flip(c);
    return 0;
  }

 private:
  /// The five edges of the two facets that a cell shows.
  double around(CellIndex c) const {
    const unsigned border = labels_.border(c);
    const auto i = static_cast<std::size_t>(std::countr_zero(border));
    const auto j = static_cast<std::size_t>(std::bit_width(border)) - 1;
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const VertexIndex v = complex_.vertex(4 * c + k);
      if (k != i) sum += over_edge(SideIndex(4 * c + i), v);
      if (k != i && k != j) sum += over_edge(SideIndex(4 * c + j), v);
    }
    return sum;
  }

  /// The surface facet over the edge opposite v, seen from the same label.
  SideIndex beyond(SideIndex side, VertexIndex v) const {
    VertexIndex behind = v;
    for (SideIndex entry = side;;) {
      std::size_t exit = entry / 4 * 4;
      while (complex_.vertex(exit) != behind) ++exit;
      if (labels_.on_border(SideIndex(exit))) return SideIndex(exit);
      behind = complex_.vertex(entry);
      entry = complex_.mate(exit);
    }
  }

  double over_edge(SideIndex side, VertexIndex v) const { return bend(side, beyond(side, v), v); }

  /// |angle| times length at the edge of `side` opposite v, between it and `next`.
  double bend(SideIndex side, SideIndex next, VertexIndex v) const {
    const Point3 m = normal(side);
    const Point3 n = normal(next);
    const auto facet = complex_.facet(side);
    const auto at = static_cast<std::size_t>(std::ranges::find(facet, v) - facet.begin());
    const double length = norm(complex_.positions[facet[(at + 1) % 3]] - complex_.positions[facet[(at + 2) % 3]]);
    return std::abs(std::atan2(norm(cross(m, n)), dot(m, n))) * length;
  }

  Point3 normal(SideIndex s) const {
    const auto [a, b, c] = complex_.outward_facet(s);
    return cross(complex_.positions[b] - complex_.positions[a], complex_.positions[c] - complex_.positions[a]);
  }

  Labelling& labels_;
  const DelaunayComplex& complex_;
};

}  // namespace

double curvature_reduction(Labelling labels) {
  Bending bending(labels);
  const double total = bending.total();
  double removed = 0;
  for (std::size_t c = 0; c < labels.complex().cells(); ++c) removed += bending.improve(CellIndex(c));
  return total > 0 ? 100 * removed / total : 0;
}

}  // namespace surfaced::boundary
