// SPDX-License-Identifier: GPL-3.0-or-later
// The 3-D Delaunay triangulation of a cloud as flat arrays in canonical order.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/base.hpp"
#include "cloud/cloud.hpp"

namespace surfaced {

/// Tetrahedron; with the vertex at infinity as fourth vertex, the space outside one facet of the convex hull.
using CellIndex = Index<struct CellTag>;
/// Side 4c+i: the facet of cell c opposite its vertex i, seen from c. Also the corner of c at vertex i.
using SideIndex = Index<struct SideTag>;
/// Position of an edge in an EdgeNumbering.
using EdgeIndex = Index<struct EdgeTag>;

/// Delaunay triangulation of V points together with the vertex at infinity (index V): a triangulated 3-sphere.
/// The same for any order in which points were inserted and for any number of threads, also where more than
/// four points lie on one sphere (symbolic perturbation).
struct DelaunayComplex {
  /// V points: those of the cloud times `scale`.
  std::vector<Point3> positions;
  /// Power of two that brings the bounding box to a size within [1, 2); 1 where that would not be exact.
  double scale = 1;
  /// Walks around edges need a cell's vertices and mates together: they stand in one half of a cache line.
  struct Cell {
    /// Ascending. The vertex at infinity, V, is the last one of an infinite cell.
    std::array<VertexIndex, 4> vertices;
    /// Side i seen from the neighbour: mate(mate(s)) == s.
    std::array<SideIndex, 4> mates;
    friend bool operator==(const Cell&, const Cell&) = default;
  };
  /// Ascending lexicographically by their vertices.
  std::vector<Cell> table;
  /// Per cell 1 if its four vertices in ascending order are negatively oriented (left-handed).
  std::vector<std::uint8_t> mirrored;
  /// The corners of vertex v are stars[star_starts[v]] .. stars[star_starts[v+1]-1], ascending. V+1 entries.
  std::vector<std::uint32_t> star_starts;
  std::vector<SideIndex> stars;

  std::size_t points() const { return positions.size(); }
  std::size_t cells() const { return table.size(); }
  /// Vertex of corner s; those of a cell stand one after the other.
  const VertexIndex& vertex(std::size_t s) const { return table[s / 4].vertices[s % 4]; }
  SideIndex mate(std::size_t s) const { return table[s / 4].mates[s % 4]; }
  bool infinite(CellIndex c) const { return table[c].vertices[3] == points(); }
  static CellIndex cell_of(SideIndex s) { return CellIndex(s / 4); }
  CellIndex neighbour(SideIndex s) const { return CellIndex(mate(s) / 4); }
  std::span<const SideIndex> star(VertexIndex v) const {
    return {stars.data() + star_starts[v], stars.data() + star_starts[v + 1]};
  }
  /// Vertices of the facet, ascending.
  std::array<VertexIndex, 3> facet(SideIndex s) const {
    const std::array<VertexIndex, 4>& v = table[s / 4].vertices;
    const std::size_t i = s % 4;
    return {v[i > 0 ? 0 : 1], v[i > 1 ? 1 : 2], v[i > 2 ? 2 : 3]};
  }
  /// Vertices of the facet in the order that turns counter-clockwise when seen from outside the cell.
  std::array<VertexIndex, 3> outward_facet(SideIndex s) const {
    std::array<VertexIndex, 3> f = facet(s);
    if (((s % 4) & 1U) != mirrored[s / 4]) std::swap(f[1], f[2]);
    return f;
  }
};

/// The six edges of a cell: local vertices of edge k, ascending; edge 5-k is the opposite one.
inline constexpr std::array<std::array<std::uint8_t, 2>, 6> kCellEdges{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// A walk around an edge, cell by cell through the facets that contain it.
class EdgeWalk {
 public:
  /// Starts in cell c at its edge from local vertex a to b; leaves it first through the side opposite
  /// the lesser of the other two vertices.
  EdgeWalk(const DelaunayComplex& complex, CellIndex c, unsigned a, unsigned b)
      : complex_(complex), a_(complex.vertex(4 * c + a)), b_(complex.vertex(4 * c + b)) {
    for (unsigned i = 4; i-- > 0;) {
      if (i == a || i == b) continue;
      entry_ = exit_;
      exit_ = SideIndex(4 * c + i);
    }
  }

  CellIndex cell() const { return CellIndex(exit_ / 4); }
  /// Side of the current cell through which the walk goes on.
  SideIndex exit() const { return exit_; }
  /// Side of the current cell through which the walk came.
  SideIndex entry() const { return entry_; }
  void advance() {
    entry_ = complex_.mate(exit_);
    const std::size_t c = entry_ / 4 * 4;
    for (std::size_t s = c; s < c + 4; ++s) {
      if (s == entry_ || complex_.vertex(s) == a_ || complex_.vertex(s) == b_) continue;
      exit_ = SideIndex(s);
      return;
    }
  }

 private:
  const DelaunayComplex& complex_;
  VertexIndex a_;
  VertexIndex b_;
  SideIndex entry_;
  SideIndex exit_;
};

/// The finite edges 0..E-1, ascending by (lesser, greater end).
struct EdgeNumbering {
  /// The edges whose lesser end is v are starts[v] .. starts[v+1]-1. V+1 entries.
  std::vector<std::uint32_t> starts;
  std::vector<VertexIndex> greater;
  std::size_t edges() const { return greater.size(); }
  /// The edge from a to b. Precondition: a < b, and there is such an edge.
  /// @cost  logarithmic in the edges at a.
  EdgeIndex find(VertexIndex a, VertexIndex b) const;
  /// Asks for what find(a, ...) reads.
  void prefetch(VertexIndex a) const { __builtin_prefetch(greater.data() + starts[a]); }
};

/// @cost  O(cells); about 35 bytes per point on surfaces.
EdgeNumbering number_edges(const DelaunayComplex& complex, unsigned threads);

/// Cells as a triangulator gives them: any order, any order of the vertices. The vertex at infinity has
/// index V. Invariants: mates[i] is 4c'+i' for the facet opposite vertices[i] seen from its other cell c'; the
/// vertices of a cell are positively oriented (the order of an infinite cell: as if the vertex at infinity stood
/// far off outside the hull facet).
struct RawTriangulation {
  struct Cell {
    std::array<std::uint32_t, 4> vertices;
    std::array<std::uint32_t, 4> mates;
  };
  int dimension = 3;
  std::vector<Cell> cells;
};

/// Sides are numbered 4c+i in 32 bits.
inline constexpr std::size_t kMostCells = Index<void>::kNone / 4;

/// Triangulates distinct points; the way to put another Delaunay triangulation in this one's place.
/// It must break ties on common spheres as the perturbation of Devillers and Teillaud does, so that the cells do
/// not depend on the order of insertion.
using Triangulator = Result<RawTriangulation> (*)(std::span<const Point3> points, Context& context);

/// Incremental insertion (Bowyer, Watson) into flat arrays, with exact predicates.
/// @cost  O(V log V) expected for points on surfaces in Morton order; 32 bytes a cell, and nothing else that grows.
Result<RawTriangulation> triangulate(std::span<const Point3> points, Context& context);

/// CGAL's Delaunay triangulation: the same cells in more time and memory.
Result<RawTriangulation> triangulate_with_cgal(std::span<const Point3> points, Context& context);

/// Triangulates the cloud and flattens the result; enters the stages `delaunay` (up to
/// 3/4 of `until`) and `flatten` (up to `until`).
/// @return  too_few_points, collinear or coplanar (exact) with the number of distinct points; cancelled.
/// @cost    O(V log V) expected for points on surfaces; 0.35 kB per point kept, about 0.55 kB at the peak.
Result<DelaunayComplex> delaunay_complex(const PointCloud& cloud, Context& context, double until,
                                         Triangulator triangulator = triangulate);

}  // namespace surfaced
