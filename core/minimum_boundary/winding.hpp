// SPDX-License-Identifier: GPL-3.0-or-later
// Inside and outside by the winding number of a surface that need not be closed nor made of Delaunay facets.
#pragma once

#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "delaunay/delaunay.hpp"
#include "minimum_boundary/guiding_surface.hpp"

namespace surfaced::boundary {

/// Generalised winding number (Jacobson and others 2013): the solid angle of all triangles over 4π; those far off stand
/// in for one another by their common area vector (Barill and others 2018).
class WindingNumber {
 public:
  explicit WindingNumber(const GuidingSurface& surface);

  /// About 1 inside, 0 outside.
  /// @cost  logarithmic in the triangles, for places that are not next to all of them.
  double at(const Point3& place) const;

 private:
  /// Triangles begin..end-1, all within `radius` of the centre.
  struct Node {
    std::size_t begin;
    std::size_t end;
    Point3 centre{};
    double radius = 0;
    Point3 area{};
  };

  void build(std::size_t node, std::size_t begin, std::size_t end);
  double solid_angle(std::size_t triangle, const Point3& place) const;

  const GuidingSurface& surface_;
  /// A binary tree: children of node k are 2k+1 and 2k+2. Near indices mean near places.
  std::vector<Node> nodes_;
};

/// Finite cells whose centroid has a winding number above a half are IN.
/// @return  per cell 1 for IN, 0 for OUT; meaningless once the context is cancelled.
/// @cost    O(cells log triangles), parallel.
std::vector<std::uint8_t> wound_labels(const DelaunayComplex& complex, const GuidingSurface& guide,
                                       const Context& context, unsigned threads);

}  // namespace surfaced::boundary
