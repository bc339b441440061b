// SPDX-License-Identifier: GPL-3.0-or-later
// Fewer triangles for an oriented manifold, with the distance this costs.
#pragma once

#include <cstddef>

#include "base/base.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

/// A mesh with fewer triangles.
struct Simplified {
  TriangleMesh mesh;
  /// No point of either surface is farther than this from the other (two-sided Hausdorff distance, from above, as a
  /// rule at most 10 % too large); in units of the input.
  double distance = 0;
};

/// Collapses edges until at most `triangles` are left, or no edge can be collapsed without changing the topology.
/// Closed stays closed, genus and components stay, boundaries stay in number. Vertices that no collapse touches keep
/// their bits; the others get the place of least quadric error, held by float32 if the input is, and the normal and
/// colour of the closest point of the input.
/// @pre     no directed edge is used twice; where several umbrellas share a vertex, each gets one of its own.
/// @return  cancelled, out_of_memory, or method_failed if the mesh is not oriented or not edge-manifold.
/// @cost    O(F log F); about 1.2 KB a vertex.
Result<Simplified> simplified_to(const TriangleMesh& mesh, std::size_t triangles, Context& context);

/// As few triangles as found in at most four attempts whose `distance` is at most the given one (> 0); the mesh
/// itself, at distance 0, if every attempt went too far.
Result<Simplified> simplified_within(const TriangleMesh& mesh, double distance, Context& context);

}  // namespace surfaced
