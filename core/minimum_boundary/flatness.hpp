// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds that lie in a plane or on a line but for rounding or noise: no body is determined.
#pragma once

#include "base/base.hpp"
#include "cloud/cloud.hpp"

namespace surfaced::boundary {

/// Refuses points whose distances from a plane, or a line, are a small part of the distance between neighbours, or no
/// more than the steps of the float32 coordinates they come in. Few points have to be nearer to it: four corners of a
/// thin wedge are a body.
/// @return  coplanar, collinear, with the number of points and how far they lie from the plane or line.
/// @cost    O(V); nearest neighbours only where the points are flat enough to be suspected.
Status refuse_flat(const PointCloud& cloud, unsigned threads);

}  // namespace surfaced::boundary
