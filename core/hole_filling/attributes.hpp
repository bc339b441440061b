// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room.
#pragma once

#include "hole_filling/boundary_loops.hpp"
#include "hole_filling/patch.hpp"

namespace surfaced::filling {

/// Appends normals and colours of the patch's new points to a mesh that has them, spread harmonically from the corners
/// of the loop.
void append_attributes(TriangleMesh& mesh, const BoundaryLoop& loop, const Patch& patch);

}  // namespace surfaced::filling
