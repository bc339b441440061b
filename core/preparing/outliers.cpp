// SPDX-License-Identifier: GPL-3.0-or-later
// The criterion of CGAL's remove_outliers (mean distance to the nearest points), with a limit relative to the median,
// so that nobody has to know how many outliers there are.
#include "preparing/neighbourhood.hpp"
#include "preparing/stage.hpp"

namespace surfaced {

Result<PointCloud> without_outliers(const PointCloud& cloud, double factor, Context& context) {
  constexpr std::size_t kNeighbours = 12;
  return preparing::guarded<PointCloud>("the removal of outliers", context, [&]() -> Result<PointCloud> {
    const std::vector<double> means = preparing::mean_distances(cloud.positions, kNeighbours, context.threads());
    const double limit = factor * preparing::median_of(means);
    std::vector<std::size_t> kept;
    for (std::size_t v = 0; v < means.size(); ++v) {
      if (means[v] <= limit) kept.push_back(v);
    }
    return preparing::chosen(cloud, kept, context.threads());
  });
}

}  // namespace surfaced
