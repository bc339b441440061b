// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "front/front.hpp"

namespace surfaced::ldt {

/// The paper's start (algorithm 1, step 4): the 2-D Delaunay triangulation of v and its n nearest neighbours in the
/// tangent plane of v, all of it. Only where no face is near. @return false if it would not be manifold.
bool seed_local_triangulation(front::Fans& fans, front::Places& places, std::uint32_t v, std::size_t n);

}  // namespace surfaced::ldt
