// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: openings of a scan, behind a method that may draw triangles across them.
#pragma once

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// Schema of the parameter `openings`.
Json openings_property();

/// Drops what spans openings (mesh/spanning.hpp), or only says so, as the parameter `openings` asks.
void run_openings_parameter(Reconstruction& result, const Json& parameters);

}  // namespace surfaced
