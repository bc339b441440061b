// SPDX-License-Identifier: GPL-3.0-or-later
// Triangle meshes as flat arrays, their half-edge view, and what their topology is.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/base.hpp"
#include "base/union_find.hpp"

namespace surfaced {

using Triangle = std::array<VertexIndex, 3>;

/// V vertices, F triangles. Invariant: every index is below V; the three of a triangle differ.
/// normals and colors are empty or as long as positions.
struct TriangleMesh {
  std::vector<Point3> positions;
  std::vector<Triangle> triangles;
  std::vector<Normal3> normals;
  std::vector<Color4> colors;
};

/// Half-edge h = 3t+i of F triangles runs from corner i to corner (i+1) mod 3 of triangle t.
/// `mate[h]` is the half-edge in the opposite direction where the edge has exactly two triangles
/// and they agree in orientation; otherwise it is not valid. `edge_of[h]` numbers undirected edges 0..E-1.
class HalfEdges {
 public:
  /// @cost  O(F) by radix sort; 24 bytes per triangle.
  HalfEdges(std::span<const Triangle> triangles, std::size_t vertices);

  static HalfEdgeIndex next(HalfEdgeIndex h) { return HalfEdgeIndex(h % 3 == 2 ? h - 2 : h + 1); }
  static HalfEdgeIndex previous(HalfEdgeIndex h) { return HalfEdgeIndex(h % 3 == 0 ? h + 2 : h - 1); }

  HalfEdgeIndex mate(HalfEdgeIndex h) const { return mate_[h]; }
  std::size_t edge_of(HalfEdgeIndex h) const { return edge_of_[h]; }
  std::size_t edges() const { return uses_.size(); }
  /// Number of triangles at the edge.
  std::size_t uses(std::size_t edge) const { return uses_[edge]; }

 private:
  std::vector<HalfEdgeIndex> mate_;
  std::vector<std::uint32_t> edge_of_;
  std::vector<std::uint32_t> uses_;
};

/// What holds for the triangles of a mesh; vertices that no triangle uses are left out of all of it.
struct Topology {
  std::size_t vertices = 0;
  std::size_t edges = 0;
  std::size_t triangles = 0;
  /// Every edge has exactly two triangles; false for an empty mesh.
  bool closed = false;
  /// No edge has more than two triangles.
  bool edge_manifold = false;
  /// The triangles at every vertex form one fan or one umbrella.
  bool vertex_manifold = false;
  /// No directed edge is used twice.
  bool oriented = false;
  /// Parts connected through shared vertices.
  std::size_t components = 0;
  /// V - E + F.
  std::int64_t euler_characteristic = 0;
  /// Sum over the components, every boundary loop counted as filled; none unless edge- and
  /// vertex-manifold and oriented.
  std::optional<std::int64_t> genus;
  /// Closed chains of edges with one triangle; at a vertex where several chains touch they are taken apart by fans.
  std::size_t boundary_loops = 0;
  std::size_t boundary_edges = 0;
  std::size_t non_manifold_edges = 0;
  std::size_t non_manifold_vertices = 0;
};

/// @cost  O(V + F).
Topology topology_of(const TriangleMesh& mesh);

/// Component of every triangle, numbered from 0 in the order of their first triangles; triangles
/// that share a vertex are in one component.
struct Components {
  std::vector<std::uint32_t> of_triangle;
  std::size_t count = 0;
};
Components components_of(const TriangleMesh& mesh);

/// The fan or umbrella of every corner (corner h is where half-edge h starts): corners at one vertex whose triangles
/// are joined across edges of two triangles that agree in orientation.
/// @cost  O(F).
UnionFind fans_of_corners(const TriangleMesh& mesh);

/// Signed volume enclosed by the given triangles (positive when they face outwards), by the
/// divergence theorem about the first vertex, so that a far-off origin costs no digits.
double signed_volume(const TriangleMesh& mesh);

/// Turns every oriented component as a whole so that it faces outwards: a closed one by its volume, an open
/// one away from its centre (a convention, not a fact, for an open sheet; see face in facing.hpp). Components that are
/// not oriented stay as they are.
void orient_outwards(TriangleMesh& mesh);

/// The same for a mesh that is known to be oriented.
/// @cost  O(V + F); 4 bytes per triangle instead of the half-edges.
void orient_oriented_outwards(TriangleMesh& mesh);

/// Turns the triangles so that the least vertex of each comes first and sorts them: the same set of
/// triangles then always has the same bytes.
void sort_triangles(TriangleMesh& mesh);

}  // namespace surfaced
