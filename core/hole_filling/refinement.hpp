// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room.
#pragma once

#include "hole_filling/hole_filling.hpp"
#include "hole_filling/laplacian.hpp"
#include "hole_filling/patch.hpp"

namespace surfaced::filling {

/// Moves the new points of a patch to where the surface around the hole leads (paper 3, §3.3): normals that are
/// harmonic between those at the boundary, triangles turned to them, and the points whose edges fit the turned
/// triangles best (a Poisson equation). Corners stay. If a system cannot be solved, the points stay too.
/// @param harmonic  what normals and membranes are harmonic for; Poisson's equation always takes cotangents, whose
///                  divergence belongs to the triangles, and Rotation::paper always takes Belkin's weights.
void refine(Patch& patch, const Hole& hole, Rotation rotation, Weights harmonic = cotangent_weights);

/// Values given at the corners, spread harmonically over all points of the patch.
std::vector<Point3> spread_harmonically(const Patch& patch, std::span<const Point3> at_corners,
                                        Weights harmonic = cotangent_weights);

}  // namespace surfaced::filling
