// SPDX-License-Identifier: GPL-3.0-or-later
// The star and the edges of a vertex, cut apart by walls: the facets of a set and those between IN and OUT.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "minimum_boundary/boundary_complex.hpp"
#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

/// BC in the state that hull, conforming and hole covering work on: a set of facets and the cells already
/// taken in. What the paper calls triangles of BC are the walls.
struct Walls {
  const Labelling& labels;
  const FacetSet& facets;

  const DelaunayComplex& complex() const { return labels.complex(); }
  bool contains(SideIndex s) const { return facets.contains(s) || labels.on_border(s); }
  /// A side of the hull H(BC): a wall seen from outside. A deflated triangle has two.
  bool hull_side(SideIndex s) const { return !labels.in(CellIndex(s / 4)) && contains(s); }
};

/// Groups of the cells around a vertex that are connected without crossing walls.
class WalledStar {
 public:
  struct Group {
    bool outside;
    std::vector<CellIndex> cells;
  };

  explicit WalledStar(const DelaunayComplex& complex) : mark_(complex.cells(), 0) {}
  const std::vector<Group>& groups(const Walls& walls, VertexIndex v);

 private:
  std::vector<std::uint32_t> mark_;
  std::uint32_t epoch_ = 0;
  std::vector<Group> groups_;
};

/// The hull side met when turning from a hull side over the edge opposite the facet's vertex `behind`
/// through the outside.
SideIndex next_hull_side(const Walls& walls, SideIndex side, VertexIndex behind);

}  // namespace surfaced::boundary
