// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: which side of the surface is its front, one rule for all methods.
#pragma once

#include <optional>

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

Json orienting_properties();

/// Turns the parts of the mesh and the normals of its vertices (mesh/facing.hpp); `orientation` says how. A mesh that
/// was the input stays as it is unless `orient` says otherwise.
/// @param sensor  where the points were measured from, if the file tells.
void orient(Reconstruction& result, const Json& parameters, const std::optional<Point3>& sensor);

/// What is to be said of a closed mesh with a negative volume.
std::vector<std::string> warnings_of_inward_faces(const Json& volume);

}  // namespace surfaced
