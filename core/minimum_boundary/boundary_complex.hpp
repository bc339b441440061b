// SPDX-License-Identifier: GPL-3.0-or-later
// The boundary complex BC_0 (§4.3, 4.4, Algorithm 1).
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "delaunay/delaunay.hpp"
#include "minimum_boundary/criterion.hpp"

namespace surfaced::boundary {

/// A set of finite facets, one bit for each side of each cell; both sides of a facet agree.
class FacetSet {
 public:
  explicit FacetSet(const DelaunayComplex& complex) : bits_(complex.cells(), 0) {}
  /// Bit i of sides[c]: side i of cell c is in the set. Precondition: both sides of a facet agree.
  explicit FacetSet(std::vector<std::uint8_t> sides) : bits_(std::move(sides)) {}

  bool contains(SideIndex s) const { return ((unsigned{bits_[s / 4]} >> (s % 4)) & 1U) != 0; }
  /// Bit i: side i of the cell is in the set.
  unsigned of_cell(CellIndex c) const { return bits_[c]; }
  void prefetch(SideIndex s) const { __builtin_prefetch(&bits_[s / 4]); }
  void insert(const DelaunayComplex& complex, SideIndex s) {
    bits_[s / 4] |= static_cast<std::uint8_t>(1U << (s % 4));
    const SideIndex mate = complex.mate(s);
    bits_[mate / 4] |= static_cast<std::uint8_t>(1U << (mate % 4));
  }
  void erase(const DelaunayComplex& complex, SideIndex s) {
    bits_[s / 4] &= static_cast<std::uint8_t>(~(1U << (s % 4)));
    const SideIndex mate = complex.mate(s);
    bits_[mate / 4] &= static_cast<std::uint8_t>(~(1U << (mate % 4)));
  }
  friend bool operator==(const FacetSet&, const FacetSet&) = default;

 private:
  std::vector<std::uint8_t> bits_;
};

struct BoundaryComplex {
  FacetSet facets;
  std::size_t size = 0;
  /// Facets that were rejected first and came back when one of their edges became a boundary edge.
  std::size_t reinserted = 0;
};

/// Algorithm 1: facets in ascending λ, each taken if it has a vertex not yet used, or a boundary edge, or
/// (connected) joins two connected components. No edge of the result has exactly one facet; every vertex
/// has one.
/// @param meanwhile  work that does not depend on the result, for the threads that Algorithm 1 has no use for; it is
///                   told how many. It is done when the call returns.
/// @return  cancelled.
/// @cost    O(V) facets, sorted by radix; about 0.25 kB per point while it runs.
Result<BoundaryComplex> boundary_complex(const DelaunayComplex& complex, const Criterion& criterion, bool connected,
                                         Context& context, const std::function<void(unsigned threads)>& meanwhile = {});

}  // namespace surfaced::boundary
