// SPDX-License-Identifier: GPL-3.0-or-later
// λ, the criterion that the paper minimises (§4.2, equation 1).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "delaunay/delaunay.hpp"

namespace surfaced::boundary {

/// λ of a facet: the length of its longest edge. Comparisons use the square in double, ties the sorted
/// vertices; sums use 64-bit fixed point, so that they depend neither on order nor on threads.
class Criterion {
 public:
  explicit Criterion(const DelaunayComplex& complex)
      : complex_(complex), per_unit_(std::ldexp(1.0, kFractionBits) / diagonal(complex)) {}

  /// λ² in the scaled unit. The operands of every difference stand in the order of the vertices.
  double squared(SideIndex s) const { return squared(complex_.facet(s)); }
  double squared(const std::array<VertexIndex, 3>& facet) const {
    const auto [a, b, c] = facet;
    return std::max({edge_squared(a, b), edge_squared(a, c), edge_squared(b, c)});
  }
  /// The squares of all three edges, longest first. Facets around one edge have the same λ: the shorter edges tell them
  /// apart by shape, where their vertices would by chance.
  std::array<double, 3> squares(const std::array<VertexIndex, 3>& facet) const {
    const auto [a, b, c] = facet;
    std::array<double, 3> edges{edge_squared(a, b), edge_squared(a, c), edge_squared(b, c)};
    if (edges[0] < edges[1]) std::swap(edges[0], edges[1]);
    if (edges[1] < edges[2]) std::swap(edges[1], edges[2]);
    if (edges[0] < edges[1]) std::swap(edges[0], edges[1]);
    return edges;
  }
  double edge_squared(VertexIndex a, VertexIndex b) const {
    const Point3 d = complex_.positions[b] - complex_.positions[a];
    return dot(d, d);
  }

  /// λ in units of the bounding box's diagonal / 2^40. λ <= diagonal, so 2^23 longest facets fit a sum.
  std::int64_t energy(SideIndex s) const { return rounded(std::sqrt(squared(s)) * per_unit_); }

  /// Those of the four sides of a finite cell.
  std::array<std::int64_t, 4> energies(CellIndex c) const {
    const auto& [p, q, r, s] = complex_.table[c].vertices;
    const double pq = edge_squared(p, q);
    const double pr = edge_squared(p, r);
    const double ps = edge_squared(p, s);
    const double qr = edge_squared(q, r);
    const double qs = edge_squared(q, s);
    const double rs = edge_squared(r, s);
    const auto energy = [&](double a, double b, double e) {
      return rounded(std::sqrt(std::max(std::max(a, b), e)) * per_unit_);
    };
    return {energy(qr, qs, rs), energy(pr, ps, rs), energy(pq, ps, qs), energy(pq, pr, qr)};
  }

  /// Ascending λ, ties by the second longest edge, then the shortest, then lexicographically.
  bool less(SideIndex a, SideIndex b) const {
    const auto first = squares(complex_.facet(a));
    const auto second = squares(complex_.facet(b));
    return first != second ? first < second : complex_.facet(a) < complex_.facet(b);
  }

  /// An energy in the unit of the input.
  double length(std::int64_t energy) const { return static_cast<double>(energy) / per_unit_ / complex_.scale; }

 private:
  /// As llround, for numbers that are not negative and fit; without the call.
  static std::int64_t rounded(double x) {
    const auto whole = static_cast<std::int64_t>(x);
    return x - static_cast<double>(whole) >= 0.5 ? whole + 1 : whole;
  }

  static constexpr int kFractionBits = 40;
  static double diagonal(const DelaunayComplex& complex) { return bounds_of(complex.positions).diagonal(); }

  const DelaunayComplex& complex_;
  double per_unit_;
};

}  // namespace surfaced::boundary
