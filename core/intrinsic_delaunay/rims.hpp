// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "front/front.hpp"

namespace surfaced::idt {

/// Paper 3's "proper edge length threshold" at boundaries. A front also fills what a rim leaves concave, with ever
/// larger triangles; this takes them away again, the largest circumcircle first, where its diameter exceeds the longest
/// edge allowed. Every vertex keeps a face and no rim touches itself: only faces with one open edge and no third vertex
/// on a rim go (the rule of characteristic shapes, Duckham et al. 2008). Does nothing where the longest edge is not
/// limited.
/// @return  how many faces were taken away.
/// @cost    O(rim), O(log rim) per face.
std::size_t peel_rims(front::Fans& fans, front::Places& places);

}  // namespace surfaced::idt
