// SPDX-License-Identifier: GPL-3.0-or-later
// Down-sampling to one point a cell of a grid. Not by CGAL, which keeps the first point of a cell and so depends on
// their order.
#include <algorithm>
#include <array>
#include <cmath>

#include "preparing/stage.hpp"

namespace surfaced {
namespace {

/// A point in its cell; the nearest to the cell's centre comes first, then the one of lesser index.
struct Candidate {
  std::array<double, 3> cell;
  double squared_distance = 0;
  std::size_t point = 0;

  friend auto operator<=>(const Candidate&, const Candidate&) = default;
};

/// Points that repeat within a tolerance would say how near they are to each other, not how dense the cloud is.
Result<double> spacing_without_repeats(const PointCloud& cloud, Context& context) {
  const std::optional<NearRepeats> repeats = near_repeats_of(cloud.positions);
  if (!repeats) return spacing_of(cloud.positions, context.threads());
  const Result<PointCloud> once = fused(cloud, repeats->tolerance, context);
  if (!once) return once.error();
  return spacing_of(once->positions, context.threads());
}

Candidate candidate_of(const Point3& p, const Point3& low, double size, std::size_t point) {
  Candidate candidate{.cell = {}, .point = point};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double place = (p[axis] - low[axis]) / size;
    candidate.cell.at(axis) = std::floor(place);
    const double off = place - candidate.cell.at(axis) - 0.5;
    candidate.squared_distance += off * off;
  }
  return candidate;
}

}  // namespace

Result<PointCloud> sampled(const PointCloud& cloud, std::optional<double> cell, Context& context) {
  constexpr double kSpacings = 2;
  return preparing::guarded<PointCloud>("sampling", context, [&]() -> Result<PointCloud> {
    const Result<double> spacing = cell ? Result<double>(0.0) : spacing_without_repeats(cloud, context);
    if (!spacing) return spacing.error();
    const double size = cell ? *cell : kSpacings * *spacing;
    const auto [low, high] = bounds_of(cloud.positions);
    // In cells that small, whose numbers a double cannot hold, every point is alone.
    constexpr double kMostCells = 0x1p53;
    if (!(size > 0) || !(std::ranges::max(high - low) / size < kMostCells)) return cloud;
    std::vector<Candidate> candidates;
    candidates.reserve(cloud.size());
    for (std::size_t v = 0; v < cloud.size(); ++v) {
      candidates.push_back(candidate_of(cloud.positions[v], low, size, v));
    }
    std::ranges::sort(candidates, [](const Candidate& a, const Candidate& b) { return a < b; });
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (i == 0 || candidates[i].cell != candidates[i - 1].cell) kept.push_back(candidates[i].point);
    }
    std::ranges::sort(kept);
    return preparing::chosen(cloud, kept, context.threads());
  });
}

}  // namespace surfaced
