// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/base.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

/// What data can say of a premise of a theorem: that it holds, or fails, of the mesh; that it follows from what was
/// estimated; or nothing.
enum class Premise : std::uint8_t { holds, fails, estimated, assumed };

/// The ratios of paper 3, theorems 2 and 3, against their bounds; violations counts triangles outside, and all that
/// have no area.
struct RatioBounds {
  double lower = 0;
  double upper = 0;
  std::size_t violations = 0;
};

/// Bounds for one value of κε, and how the triangles stand to them.
struct QualityBounds {
  /// ½ − κ²ε²/48 ≤ l/R ≤ √3; a lower bound below 0 says nothing and is given as 0.
  RatioBounds shortest_edge_to_circumradius;
  /// (1/48)(1 − κ²ε²/24)² ≤ r/L ≤ √3/6; 0 likewise from κε = √24 on.
  RatioBounds inradius_to_longest_edge;
  bool met() const { return shortest_edge_to_circumradius.violations == 0 && inradius_to_longest_edge.violations == 0; }
};

/// Paper 3, section 2, for one mesh: estimates of κ and ε, the premises of its corollary 1 (and the one that it
/// forgets, edges of at least ε/2), and the bounds that follow from them. A statement about estimates, not a proof.
struct Certificate {
  /// κ: the largest absolute principal curvature at a vertex, by fitting a quadric to the rings around it (2nd-order
  /// jets); in 1/unit. The bounds use the largest.
  double largest_curvature = 0;
  double curvature_p99 = 0;
  /// Vertices with too few neighbours for a quadric.
  std::size_t vertices_without_curvature = 0;
  /// ε: the largest circumradius of a triangle with area.
  double epsilon = 0;
  double shortest_edge = 0;
  /// Edges whose opposite angles add up to more than π: there the mesh is no intrinsic Delaunay triangulation.
  std::size_t edges_beyond_pi = 0;

  /// 1/(8κ); none for a plane.
  std::optional<double> largest_epsilon;
  /// ε ≤ 1/(8κ).
  Premise epsilon_within_curvature = Premise::fails;
  /// Shortest edge ≥ ε/2.
  Premise edges_long_enough = Premise::fails;
  /// The surface has no boundary: the mesh is closed.
  Premise without_boundary = Premise::fails;
  /// inj(S) ≥ π/κ and conv(S) ≥ π/(2κ) of a closed surface: the Gaussian curvature is κ² at most, so conjugate points
  /// are π/κ apart at least (Rauch); a closed geodesic bends in space by κ at most and by 2π in all (Fenchel), so it is
  /// 2π/κ long at least; half of that, and the conjugate radius, bound inj(S) (Klingenberg), and both conv(S)
  /// (Whitehead). None without a curvature.
  std::optional<double> injectivity_radius;
  std::optional<double> convexity_radius;
  /// ε ≤ conv(S), ½ inj(S), by these bounds: estimated at best, since κ is; assumed where a vertex has no curvature.
  /// Fails also where two vertices face away from each other within 2ε, far from each other on the mesh.
  Premise injectivity_and_convexity = Premise::assumed;
  /// Two such vertices.
  std::optional<std::array<VertexIndex, 2>> close_sheets;

  /// Meaningless unless bounds_apply().
  QualityBounds bounds;
  /// The same for ε = 1/(8κ), the largest that the theorem takes: about 0.4997 and 0.0208, in the paper 0.5 and 0.021.
  QualityBounds bounds_at_largest_epsilon;
  /// Triangles outside either, farthest first, at most 100.
  std::vector<TriangleIndex> worst_triangles;

  /// What the corollary says if its premises hold: Hausdorff distance 4κε², distance of unit normals 9κε.
  double hausdorff_bound = 0;
  double normal_bound = 0;

  /// Whether the theorem says anything of the triangles: ε ≤ 1/(8κ). Beyond, its formulas fall, to 0 in
  /// the end, and worse meshes would keep them more easily.
  bool bounds_apply() const { return epsilon_within_curvature != Premise::fails; }

  /// Fails if one fails, else as the last premise.
  Premise premises_met() const;
};

/// Vertices at the same place count as one. The area of a triangle is half the cross product of its two shortest edges
/// (quality), which keeps its digits for needles as Kahan's formula does, and is 0 for collinear corners.
/// @return  coordinate_not_finite or coordinate_out_of_range, out_of_memory, cancelled; method_failed without
/// triangles.
/// @cost    O(V log V + F): about 10 µs per vertex, in parallel; 250 bytes per vertex.
Result<Certificate> certify(const TriangleMesh& mesh, Context& context);

}  // namespace surfaced
