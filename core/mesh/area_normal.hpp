// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh/mesh.hpp"

namespace surfaced {

/// The normal of the triangle, twice as long as its area.
inline Point3 area_normal(const TriangleMesh& mesh, const Triangle& t) {
  return cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
}

}  // namespace surfaced
