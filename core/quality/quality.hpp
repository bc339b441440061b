// SPDX-License-Identifier: GPL-3.0-or-later
// Measures meshes; never repairs them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
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

/// The two ratios at every vertex: the least of the triangles there; 0 at vertices without triangles.
struct VertexQuality {
  std::vector<float> shortest_edge_to_circumradius;
  std::vector<float> inradius_to_longest_edge;
};
VertexQuality vertex_quality(const TriangleMesh& mesh);

/// Closest points of a mesh's surface. Triangles without an area are left out: their edges are those of others.
class SurfaceSearch {
 public:
  struct Closest {
    Point3 point;
    TriangleIndex triangle;
    /// What names the triangle in a search, for `closest` and `distance_to`.
    std::size_t place = 0;
    double distance = 0;
  };

  /// @cost  O(F log F); about 200 bytes a triangle.
  explicit SurfaceSearch(const TriangleMesh& mesh);
  ~SurfaceSearch();
  SurfaceSearch(const SurfaceSearch&) = delete;
  SurfaceSearch& operator=(const SurfaceSearch&) = delete;

  /// No triangle has an area; then there is nothing to be close to.
  bool empty() const;
  /// @param hint  `place` of a triangle that may be near: only the time depends on it.
  Closest closest(const Point3& query, std::size_t hint = 0) const;
  double distance_to(std::size_t place, const Point3& query) const;
  /// The ends of the edge that two triangles have in common, by their coordinates; none if they have not exactly one.
  std::optional<std::array<Point3, 2>> shared_edge(std::size_t place, std::size_t other) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The greatest distance of any point of one surface from another (one-sided Hausdorff distance) lies between these.
struct SurfaceDistance {
  double lower = 0;
  double upper = 0;
};

/// Branch and bound over pieces of the triangles, after "distances to a convex set are convex" (M. Tang, M. Lee, Y.
/// Kim, "Interactive Hausdorff distance computation for general polygonal models", SIGGRAPH 2009).
/// @return  bounds 10 % apart, or further where 60 cuts a triangle did not suffice; 0 and 0 without triangles.
/// @cost    about 4 us a cut; 50,000 triangles that lie across 270,000 take a million.
SurfaceDistance surface_distance(const TriangleMesh& from, const SurfaceSearch& to, unsigned threads = 1);

/// Asked every few milliseconds, by any of the threads, whether to go on; told how much is done (0..1).
using GoOn = std::function<bool(double done)>;
/// The same; none once it shall not go on.
std::optional<SurfaceDistance> surface_distance(const TriangleMesh& from, const SurfaceSearch& to, unsigned threads,
                                                const GoOn& go_on);

/// How thick the body is behind `samples` places spread evenly over the surface of a closed, oriented mesh: from
/// there against the normal to the next wall. Ascending; fewer than asked for where a ray meets nothing.
/// @cost  O(F log F) for a tree, then O(log F) a sample.
std::vector<double> wall_thicknesses(const TriangleMesh& mesh, std::size_t samples);

/// Number of the given points that lie strictly inside a closed mesh (exact predicates; points on the
/// surface do not count). The mesh must be closed.
/// @cost  O(F log F) to build a tree, then O(log F) per point.
std::size_t count_points_inside(const TriangleMesh& mesh, std::span<const Point3> points);

/// Pairs of triangles that intersect other than in a shared vertex or edge, by CGAL's exact
/// predicates; degenerate triangles are left out. Stops counting at `cap`.
/// @cost  O(F log F + pairs).
std::size_t count_self_intersections(const TriangleMesh& mesh, std::size_t cap = 100'000);

/// The same pairs, at least one of each among the triangles from `first` on, in any order; some again in the other
/// order.
std::vector<std::array<std::uint32_t, 2>> intersections_from(const TriangleMesh& mesh, std::size_t first);

}  // namespace surfaced
