// Measures meshes; never repairs them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/base.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

/// Greatest possible l/R and r/L, both reached by the equilateral triangle.
inline constexpr double kMaxShortestEdgeToCircumradius = 1.7320508075688772;  // √3
inline constexpr double kMaxInradiusToLongestEdge = 0.28867513459481287;      // √3/6

/// Shape of one triangle with shortest edge l, longest edge L, circumradius R and inradius r.
struct TriangleShape {
  double shortest_edge_to_circumradius = 0;
  double inradius_to_longest_edge = 0;
  double area = 0;
};

/// Shape of the triangle abc. The area is half the cross product of the two shortest edges, which is
/// exactly 0 for collinear float32 coordinates of like size and keeps its digits for needles; a degenerate
/// triangle gives 0 for all three. (l/R = 2|a×b|/(bL) and r/L = |a×b|/(perimeter·L), so nothing is
/// divided by the area.)
TriangleShape shape_of(const Point3& a, const Point3& b, const Point3& c);

/// Distribution of one ratio over the triangles of a mesh.
struct Distribution {
  static constexpr std::size_t kBins = 20;
  double min = 0;
  double max = 0;
  double mean = 0;
  /// Percentiles by nearest rank.
  double p05 = 0;
  double p50 = 0;
  double p95 = 0;
  /// Counts of kBins equal bins over [0, upper]; values at the upper end fall in the last one.
  double upper = 0;
  std::array<std::uint64_t, kBins> histogram{};
};

/// Triangle quality and size of a mesh.
struct MeshQuality {
  /// None for a mesh without triangles.
  std::optional<Distribution> shortest_edge_to_circumradius;
  std::optional<Distribution> inradius_to_longest_edge;
  std::size_t degenerate_triangles = 0;
  double area = 0;
  /// Sum over the triangles of their longest edge, paper 1's objective.
  double longest_edge_sum = 0;
  /// Signed; none unless the mesh is closed and oriented.
  std::optional<double> volume;
};

/// @cost  O(F).
MeshQuality measure_quality(const TriangleMesh& mesh, const Topology& topology);

/// Number of the given points that lie strictly inside a closed mesh (exact predicates; points on the
/// surface do not count). The mesh must be closed.
/// @cost  O(F log F) to build a tree, then O(log F) per point.
std::size_t count_points_inside(const TriangleMesh& mesh, std::span<const Point3> points);

/// Pairs of triangles that intersect other than in a shared vertex or edge, by CGAL's exact
/// predicates; degenerate triangles are left out. Stops counting at `cap`.
/// @cost  O(F log F + pairs).
std::size_t count_self_intersections(const TriangleMesh& mesh, std::size_t cap = 100'000);

}  // namespace surfaced
