// SPDX-License-Identifier: GPL-3.0-or-later
// Whether the points show one body or several.
#pragma once

#include <cstddef>

#include "delaunay/delaunay.hpp"
#include "minimum_boundary/guiding_surface.hpp"

namespace surfaced::boundary {

/// Closed parts of the guiding surface that lie so far apart that only a bridge would join them: bodies, and the shells
/// of hollow ones. Parts of a few points count with the nearest other.
/// @return  1 if the guiding surface is one part, or is not closed.
/// @cost    O(triangles); O(cells) if there are several parts.
std::size_t count_bodies(const DelaunayComplex& complex, const GuidingSurface& guide);

}  // namespace surfaced::boundary
