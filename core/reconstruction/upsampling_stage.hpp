// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: upsampling around the method `intrinsic-delaunay`.
#pragma once

#include "intrinsic_delaunay/intrinsic_delaunay.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// Schema of the parameter `upsample`.
Json upsample_property();

/// The method with its parameters `epsilon` and `upsample`: reconstructs, adds points where triangles are larger than ε
/// and reconstructs again. Then the front takes its ε from the points, so that it spans what is to be sampled anew.
/// @param statistics  gets what upsampling did; null if it was not asked for.
Result<IntrinsicDelaunayResult> reconstruct_upsampled(const PointCloud& cloud, IntrinsicDelaunayParameters method,
                                                      const Json& parameters, Json& statistics, Context& context);

/// Counts the triangles that are larger than ε in the mesh as it is in the end, where upsampling was asked for, and
/// warns of them.
void count_large_triangles(Reconstruction& made);

}  // namespace surfaced
