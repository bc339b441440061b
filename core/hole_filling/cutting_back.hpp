// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: triangles that were stretched over holes, or into them, because nothing better was there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hole_filling/boundary_loops.hpp"
#include "mesh/mesh.hpp"

namespace surfaced::filling {

/// How far apart vertices are around a vertex: the edge of the equilateral triangles of which a surface has as many
/// vertices per area as the mesh has within three edges of it (a median, in which vertices on a boundary do not count).
class Spacings {
 public:
  /// @cost  O(V + F).
  explicit Spacings(const TriangleMesh& mesh);

  /// 0 if all vertices around are on a boundary.
  /// @cost  O(1) where degrees are bounded; nothing when asked again.
  double at(VertexIndex v);

  /// The circumradius of the triangle against the spacing that the areas at its corners alone say.
  double ratio_to_corners(std::size_t triangle) const;
  /// Nine tenths of all triangles are below this ratio.
  double usual_circumradius() const { return usual_; }

 private:
  void forget_boundary();
  double look_around(VertexIndex v);

  const TriangleMesh& mesh_;
  /// Triangles by vertex: those of v are from starts_[v] to starts_[v + 1].
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> triangles_;
  /// A third of each triangle's for every corner; not a number at a boundary.
  std::vector<float> areas_;
  std::vector<float> known_;
  /// For which vertex a vertex was looked at last.
  std::vector<std::uint32_t> seen_;
  double usual_ = 0;
};

/// Triangles to be taken away from around one hole, or from over one.
struct Cut {
  std::vector<std::uint32_t> triangles;
  /// Nothing was open there.
  bool spanned = false;
};

/// Triangles whose circumradii are much larger than usual where they are: from the rims of the given loops inwards, and
/// where they span a hole that the mesh does not show, large against the largest gaps between its vertices. What
/// is left is as manifold as it was, has all its vertices, and one loop for each of the given ones and for each span.
/// @param holes  the loops to cut back, of all loops that the mesh has.
/// @cost  O(V + F).
std::vector<Cut> cut_back(const TriangleMesh& mesh, std::span<const BoundaryLoop> loops, const std::vector<bool>& holes,
                          Spacings& spacings);

/// The mesh without the triangles of these cuts.
TriangleMesh without(const TriangleMesh& mesh, std::span<const Cut> cuts);

}  // namespace surfaced::filling
