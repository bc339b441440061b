// Stages before a method: outliers, sampling. Each takes a cloud and gives a cloud.
#pragma once

#include <optional>
#include <vector>

#include "base/base.hpp"
#include "cloud/cloud.hpp"

namespace surfaced {

/// Median over the points of their mean distance to the 6 nearest others: what "spacing" means here. 0 for one point.
/// @cost  O(V log V).
double spacing_of(const std::vector<Point3>& positions, unsigned threads);

/// Removes the points whose mean distance to their 12 nearest exceeds `factor` times the median of it.
Result<PointCloud> without_outliers(const PointCloud& cloud, double factor, Context& context);

/// Keeps one input point in every cell of a grid, the nearest to the cell's centre; `cell` is the side of a cell, in
/// units of the input, or without it twice the spacing.
Result<PointCloud> sampled(const PointCloud& cloud, std::optional<double> cell, Context& context);

}  // namespace surfaced
