// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: nearest neighbours of any place, by nanoflann.
#pragma once

#include <vector>

#include "preparing/preparing.hpp"

namespace surfaced::preparing {

/// Mean distance of every point to its k nearest others.
std::vector<double> mean_distances(const std::vector<Point3>& positions, std::size_t k, unsigned threads);

/// The k nearest others of every point, k indices each, nearest first (then lesser index); fewer than k points
/// leave VertexIndex::kNone at the end.
std::vector<std::uint32_t> neighbour_table(const std::vector<Point3>& positions, std::size_t k, unsigned threads);

/// Median by rank; 0 for none.
double median_of(std::vector<double> values);

}  // namespace surfaced::preparing
