// SPDX-License-Identifier: GPL-3.0-or-later
// Which vertex of a finished mesh each point of the input became.
#pragma once

#include <vector>

#include "cloud/cloud.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

/// For a mesh that `run` made of the cloud, or one that was read from a file. By position, so that it holds whatever
/// the method and the stages before and after it left out, merged or moved. (`cloud.input_to_vertex` numbers the points
/// of the cloud; the mesh numbers those that are left.)
/// @return  an entry for each input point: the first vertex at its position. Not valid for a point that is no vertex:
/// the
///          method left it unused, a stage dropped or moved it, or the method makes vertices of its own.
/// @cost    O(V log V + N) for V vertices and points, N input points.
std::vector<VertexIndex> vertices_of_input(const PointCloud& cloud, const TriangleMesh& mesh);

}  // namespace surfaced
