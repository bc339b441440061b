// SPDX-License-Identifier: GPL-3.0-or-later
// How densely the surface is sampled where: spacing against the local feature size.
#pragma once

#include <vector>

#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

/// Estimates of ε (an ε-sample has a point within ε times the distance to the medial axis of every place of the
/// surface): the circumradius of an equilateral triangle over the longest surface edge at a vertex, divided by the
/// distance to the nearer of its two poles, the farthest centres of the Delaunay balls through it on either side
/// (Amenta and Bern 1999).
struct Sampling {
  /// Of every vertex; 0 for points that are not on the surface.
  std::vector<float> epsilon;
  double median = 0;
  /// Exceeded by one vertex in twenty.
  double high = 0;
  /// Share of the vertices with ε above 1, where the points say little about the shape.
  double share_above_one = 0;
};

/// @cost  O(cells).
Sampling sampling_of(const Labelling& labels, unsigned threads);

}  // namespace surfaced::boundary
