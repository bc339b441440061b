// SPDX-License-Identifier: GPL-3.0-or-later
// A surface that another method laid through the same points, as evidence for what is inside and what outside.
#pragma once

#include <vector>

#include "delaunay/delaunay.hpp"
#include "mesh/mesh.hpp"
#include "minimum_boundary/watershed.hpp"

namespace surfaced::boundary {

/// Oriented triangles, closed parts facing outwards; they may leave openings and need not be Delaunay facets.
struct GuidingSurface {
  /// Where the points lie that it runs through.
  std::vector<Point3> positions;
  std::vector<Triangle> triangles;
  std::size_t open_edges = 0;
  /// Points in no triangle.
  std::size_t unused_points = 0;
};

/// The surface that local-delaunay makes of the points, after they have been moved so many times onto the plane of
/// their neighbours. Without triangles where it makes none.
/// @return  cancelled, out_of_memory.
Result<GuidingSurface> guiding_surface(std::vector<Point3> positions, unsigned smoothing_rounds, const Context& context,
                                       unsigned threads);

/// One of every group of points that lie far nearer to each other than their neighbourhood is wide, as where several
/// scans of one thing were laid over each other; in their order.
std::vector<Point3> without_repeats(const DelaunayComplex& complex, unsigned threads);

/// The guide runs through the points of the complex. Cells on either side of a triangle that is a Delaunay facet get
/// their label from it, infinite cells are OUT; the labels then spread from cell to cell across all other facets,
/// highest ball ratio first, until they meet.
/// @return  per cell 1 for IN, 0 for OUT; cells that no label reaches are IN.
/// @cost    O(cells α(cells)).
std::vector<std::uint8_t> guided_labels(const DelaunayComplex& complex, const RatedFacets& rated,
                                        const GuidingSurface& guide);

}  // namespace surfaced::boundary
