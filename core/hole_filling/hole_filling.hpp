// SPDX-License-Identifier: GPL-3.0-or-later
// Closing boundary loops of a mesh: small ones without new vertices, others by an advancing front whose points are
// then fitted to the surface around.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/base.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

/// A closed boundary loop, with the hole to the left of its edges i -> i+1.
struct Loop {
  std::vector<Point3> corners;
  /// Third vertex of the face on the other side of edge i -> i+1.
  std::vector<Point3> beyond;
};

/// What a triangulation of a loop must not do.
struct LoopLimits {
  /// Least cosine of the angle between the normals of faces that share an edge, those beyond the loop included.
  double least_cosine = -0.5;
  /// Whether corners i and j may be joined; asked for pairs that are not neighbours on the loop.
  std::function<bool(std::size_t i, std::size_t j)> may_join;
};

/// Triangulates the loop with the least total area, by dynamic programming over its sub-polygons (Barequet and
/// Sharir 1995; Liepa 2003). A sub-polygon keeps its best triangulation only, so with the limit on the bend the
/// area is the least of those found, not of all.
/// @return  triangles of positions on the loop, oriented like its edges; none if the limits allow none.
/// @cost    O(n^3) time, O(n^2) memory for n corners: for loops of tens of corners.
std::optional<std::vector<std::array<std::uint32_t, 3>>> triangulate_loop(const Loop& loop, const LoopLimits& limits);

/// How the new points of a filled hole are moved: fitted to normals spread harmonically from its boundary; by
/// Laplace's equation alone; or turned by a right angle first, as paper 3 has it.
enum class Rotation : std::uint8_t { normal, none, paper };

struct FillParameters {
  /// small: loops of up to 30 edges, without new vertices. all: every loop, with new vertices as dense as its edges.
  enum class Holes : std::uint8_t { small, all };
  Holes holes = Holes::all;
  Rotation rotation = Rotation::normal;
};

/// A boundary loop that stays.
struct LoopLeft {
  /// Its least vertex.
  VertexIndex vertex;
  std::size_t edges = 0;
  std::string reason;
};

struct FillReport {
  std::size_t loops = 0;
  /// Of those, where stretched triangles spanned a hole.
  std::size_t spans_opened = 0;
  /// Stretched triangles that new ones have taken the place of.
  std::size_t triangles_cut = 0;
  std::size_t filled = 0;
  /// Of those, by CGAL's triangulation because the advancing front stopped.
  std::size_t filled_by_library = 0;
  std::size_t vertices_added = 0;
  std::size_t triangles_added = 0;
  std::vector<LoopLeft> left;
};

/// Fills holes of a mesh (paper 3, §3.3). Input vertices stay as they are; so do triangles, except that Holes::all
/// first takes those away that are stretched into holes, or over them, against the spacing of the vertices around, with
/// which it then fills. New vertices are appended, with normals and colours spread harmonically from the boundary where
/// the mesh has them. An edge-manifold, vertex-manifold or oriented mesh stays so. Loops that would spoil that, that
/// span half the area of their component or more, or that nothing covers, are left and reported with the reason.
/// @return  cancelled; out_of_memory.
/// @cost    per hole of n edges O(n) new triangles for a long one and O(n²) for a round one, times O(log n), and the
///          comparison of every new point with the front.
Result<FillReport> fill_holes(TriangleMesh& mesh, const FillParameters& parameters, Context& context);

}  // namespace surfaced
