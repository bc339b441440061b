// SPDX-License-Identifier: GPL-3.0-or-later
// Method `minimum-boundary`: minimises edge length to connect sparsely sampled points
// (Ohrhallinger, Mudur, Wimmer 2013). A closed manifold through or around every point, for any input.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/base.hpp"
#include "cloud/cloud.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

struct MinimumBoundaryParameters {
  /// One component, or as many as the boundary complex without the connectedness condition finds (§8), or, automatic,
  /// one for each body that the points show by themselves (variant=best with lids=watershed; else one).
  enum class Components : std::uint8_t { automatic, one, many };
  /// How holes in the hull of the boundary complex are covered (§5.4 and what is stronger).
  enum class Lids : std::uint8_t { watershed, ball, paper, mincut, none };
  /// best: all candidates, fused; fast: one candidate; paper: the paper's own way.
  enum class Variant : std::uint8_t { best, fast, paper };
  /// variant=best: straight flips edges in the end where that lowers the absolute mean curvature (§8), which takes
  /// notches out of sharp edges; shortest keeps the least Σλ that was found.
  enum class Diagonals : std::uint8_t { straight, shortest };
  /// keep: what spans openings ten times as wide as the points lie apart is cut out in the end; the mesh then has a
  /// boundary.
  enum class Openings : std::uint8_t { close, keep };
  enum class StopAfter : std::uint8_t { none, boundary_complex, inflated };

  Components components = Components::automatic;
  Lids lids = Lids::watershed;
  /// Ball ratio below which lids=ball covers, and behind whose lids lids=mincut seeks its seeds; none chooses.
  std::optional<double> delta = std::nullopt;
  Variant variant = Variant::best;
  StopAfter stop_after = StopAfter::none;
  Diagonals diagonals = Diagonals::straight;
  Openings openings = Openings::close;
};

/// A labelling that was brought to a manifold, and what came of it.
struct MinimumBoundaryCandidate {
  std::string name;
  std::size_t components = 0;
  std::int64_t genus = 0;
  std::size_t interior_vertices = 0;
  double sum_lambda = 0;
};

/// Estimates of ε over the vertices.
struct MinimumBoundarySampling {
  double median = 0;
  double high = 0;
  double share_above_one = 0;
};

/// variant=best: what speaks for the result and against it.
struct MinimumBoundaryEvidence {
  /// Share of the candidates that have the genus and the components of the chosen one; those with more handles, and
  /// with fewer.
  double candidates_agreeing = 0;
  double more_handles = 0;
  double fewer_handles = 0;
  /// How much worse or better the nearest candidate of another genus scored, in mean λ; infinite if there is none.
  double gap = 0;
  /// The same of the nearest candidate whose volume is more than a quarter larger or smaller.
  double volume_gap = 0;
  /// Whether the candidate made with the guiding surface has this topology, and the closed guiding surface itself.
  bool guided_agrees = false;
  bool guide_agrees = false;
  /// Open edges and unused points of the guiding surface, for each point.
  double guide_open_edges = 0;
  double guide_unused = 0;
  /// Share of the triangles that are also the guiding surface's, and of those that face against its normals.
  double guide_shared = 0;
  double opposed_triangles = 0;
};

struct MinimumBoundaryStatistics {
  std::size_t cells = 0;
  std::size_t boundary_complex_facets = 0;
  std::size_t reinserted_facets = 0;
  /// Paper's way: cells taken in to conform (§6.1), artifacts, those with hull holes (§5.3).
  std::size_t conforming_cells = 0;
  std::size_t artifacts = 0;
  std::size_t hull_holes = 0;
  /// Facets added to cover holes, the ball ratio that lids=ball or mincut chose, and how large mincut's seeds are.
  std::size_t lids = 0;
  double delta = 0;
  double seed_factor = 0;
  std::size_t inflated_cells = 0;
  /// Cells taken in by the fallback that Theorem B shows to be unreachable.
  std::size_t forced_cells = 0;
  std::size_t exposed_vertices = 0;
  std::size_t flipped_edges = 0;
  /// variant=best: what was tried, and which one was taken as the start of fusing.
  std::vector<MinimumBoundaryCandidate> candidates;
  std::string chosen_candidate;
  /// Regions taken from the other candidates.
  std::size_t fused_regions = 0;
  /// variant=best: by how little, in mean λ, the closest choice between two topologies was made; none if no other
  /// topology was seen.
  std::optional<double> topology_margin;
  /// Handles removed by surgery.
  std::size_t removed_handles = 0;
  /// The paper's "int": points inside the surface.
  std::size_t interior_vertices = 0;
  std::size_t components = 0;
  std::int64_t genus = 0;
  /// Closed parts that lie apart, as the guiding surface shows them; 0 where there was none.
  std::size_t bodies_seen = 0;
  /// Components asked for: 1, or with components=automatic the bodies seen; 0 for any number.
  std::size_t bodies = 0;
  /// Components that were joined by bridges.
  std::size_t bridges = 0;
  /// Share of the area in triangles that span openings far wider than the points lie apart.
  double sheet_area_share = 0;
  /// Vertices with less than a tenth of the space around them inside, and with more than four fifths.
  std::size_t thin_vertices = 0;
  std::size_t buried_vertices = 0;
  /// Points that lie by themselves, where the surface has a spike.
  std::size_t outliers = 0;
  /// Spacing over distance to the medial axis: median, exceeded by one vertex in twenty, share above 1; not for
  /// variant=fast.
  std::optional<MinimumBoundarySampling> sampling;
  std::optional<MinimumBoundaryEvidence> evidence;
  /// Probability that genus, components or volume are wrong, where there is evidence.
  std::optional<double> doubt;
  /// openings=keep: triangles cut out.
  std::size_t opened_triangles = 0;
  /// Parts of the surface, of at least a hundredth of the points each, that only such triangles connect.
  std::size_t joined_parts = 0;
  /// diagonals=straight: edges flipped in the end.
  std::size_t straightened_edges = 0;
  /// The paper's "curv" in percent: what edge flips removed (variant=best with diagonals=straight), or would remove;
  /// not for variant=fast, of whose time it would be a tenth.
  std::optional<double> curvature_reduction;
  /// Sum of the longest edges of all triangles, in the unit of the input.
  double sum_lambda = 0;
};

struct MinimumBoundaryResult {
  /// Vertex v is point v of the cloud; points inside the volume are in no triangle.
  TriangleMesh mesh;
  std::vector<std::string> warnings;
  MinimumBoundaryStatistics statistics;
};

/// @return  closed, oriented, edge- and vertex-manifold, without self-intersection, every point on it or
///          inside it (with StopAfter::boundary_complex: the boundary complex, which is none of that);
///          too_few_points, collinear, coplanar, cancelled, out_of_memory.
/// @cost    O(V log V) for points on surfaces, about twice its Delaunay triangulation.
Result<MinimumBoundaryResult> minimum_boundary(const PointCloud& cloud, const MinimumBoundaryParameters& parameters,
                                               Context& context);

}  // namespace surfaced
