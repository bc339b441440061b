// SPDX-License-Identifier: GPL-3.0-or-later
// Points that repeat within a tolerance, as of several scans of one thing: two scales of neighbour distance with
// nothing between them. Recognised in a sample; fused by balls around the first of them that is left.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "preparing/stage.hpp"

namespace surfaced {
namespace {

/// Points whose neighbours are looked at, and how far along the order of the cloud, in which near means near in space.
constexpr std::size_t kQueries = 4096;
constexpr std::size_t kWindow = 64;
/// Distances are counted in classes of this many to the doubling.
constexpr double kClasses = 4;
/// Empty classes between the two scales: a factor of 2.4. The distances of a grid leave 3 empty at most.
constexpr int kLeastGap = 5;
/// A class is not empty if it has a distance for every so many queries.
constexpr std::size_t kOccupied = 50;
/// Shares of the queries with a neighbour below and beyond the gap.
constexpr double kLeastBelow = 0.1;
constexpr double kLeastBeyond = 0.5;
/// Fewer groups of points are bodies far from each other.
constexpr double kFewestSites = 64;

int class_of(double distance) { return static_cast<int>(std::floor(kClasses * std::log2(distance))); }
double low_end(int number) { return std::exp2(number / kClasses); }

/// Distances of the sampled points to those near them in the order, ascending for every one.
std::vector<std::vector<double>> window_distances(const std::vector<Point3>& positions) {
  const std::size_t step = std::max<std::size_t>(1, positions.size() / kQueries);
  std::vector<std::vector<double>> all;
  for (std::size_t v = 0; v < positions.size(); v += step) {
    const std::size_t first = v < kWindow ? 0 : v - kWindow;
    const std::size_t last = std::min(positions.size(), v + kWindow + 1);
    std::vector<double>& distances = all.emplace_back();
    for (std::size_t u = first; u < last; ++u) {
      const double distance = norm(positions[u] - positions[v]);
      if (u != v && distance > 0) distances.push_back(distance);
    }
    std::ranges::sort(distances);
  }
  return all;
}

/// The widest run of empty classes: the classes below and beyond it.
std::optional<std::array<int, 2>> widest_gap(const std::vector<std::vector<double>>& distances) {
  std::map<int, std::size_t> counts;
  for (const std::vector<double>& of_one : distances) {
    for (const double d : of_one) ++counts[class_of(d)];
  }
  std::optional<std::array<int, 2>> widest;
  std::optional<int> before;
  for (const auto& [number, count] : counts) {
    if (count * kOccupied < distances.size()) continue;
    const int gap = before ? number - *before - 1 : 0;
    if (gap >= kLeastGap && (!widest || gap > (*widest)[1] - (*widest)[0] - 1)) widest = std::array{*before, number};
    before = number;
  }
  return widest;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// A point in its cell of a grid.
struct InCell {
  std::array<double, 3> cell;
  std::size_t point = 0;

  friend auto operator<=>(const InCell&, const InCell&) = default;
};

/// The points cell by cell; those that have been taken are skipped from then on.
class CellGrid {
 public:
  CellGrid(const std::vector<Point3>& positions, double size) : positions_(positions), size_(size) {
    low_ = bounds_of(positions).low;
    for (std::size_t v = 0; v < positions.size(); ++v) points_.push_back({cell_of(positions[v]), v});
    std::ranges::sort(points_, [](const InCell& a, const InCell& b) { return a < b; });
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (i == 0 || points_[i].cell != points_[i - 1].cell) starts_.push_back(i);
    }
    starts_.push_back(points_.size());
    left_.resize(starts_.size() - 1);
    for (std::size_t c = 0; c < left_.size(); ++c) left_[c] = starts_[c + 1];
  }

  /// The points within `size` of the place that nobody has taken, ascending; they are taken now.
  std::vector<std::size_t> take_near(const Point3& place) {
    std::vector<std::size_t> found;
    const std::array<double, 3> middle = cell_of(place);
    for (int offset = 0; offset < 27; ++offset) {
      std::array<double, 3> cell = middle;
      for (std::size_t axis = 0, rest = static_cast<std::size_t>(offset); axis < 3; ++axis, rest /= 3) {
        cell.at(axis) += static_cast<double>(rest % 3) - 1;
      }
      take_in_cell(cell, place, found);
    }
    std::ranges::sort(found);
    return found;
  }

 private:
  std::array<double, 3> cell_of(const Point3& p) const {
    std::array<double, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) cell.at(axis) = std::floor((p[axis] - low_[axis]) / size_);
    return cell;
  }

  void take_in_cell(const std::array<double, 3>& cell, const Point3& place, std::vector<std::size_t>& found) {
    const auto at = std::ranges::lower_bound(starts_.begin(), starts_.end() - 1, cell, {},
                                             [&](std::size_t start) { return points_[start].cell; });
    if (at == starts_.end() - 1 || points_[*at].cell != cell) return;
    std::size_t& end = left_[static_cast<std::size_t>(at - starts_.begin())];
    // Points that are taken move behind the end; their cell's first entry, which names the cell, keeps its cell.
    for (std::size_t i = *at; i < end;) {
      if (norm(positions_[points_[i].point] - place) > size_) {
        ++i;
        continue;
      }
      found.push_back(points_[i].point);
      std::swap(points_[i], points_[--end]);
    }
  }

  const std::vector<Point3>& positions_;
  double size_;
  Point3 low_{};
  std::vector<InCell> points_;
  std::vector<std::size_t> starts_;
  /// Where the points of a cell that are left end.
  std::vector<std::size_t> left_;
};

/// Appends the mean of the points, each as often as the input had it.
void push_mean(const PointCloud& cloud, const std::vector<std::size_t>& points, const std::vector<double>& weights,
               RawCloud& raw) {
  const Point3 first = cloud.positions[points.front()];
  Point3 shift{};
  Point3 normal{};
  std::array<double, 4> color{};
  double sum = 0;
  for (const std::size_t v : points) {
    sum += weights[v];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      shift[axis] += weights[v] * (cloud.positions[v][axis] - first[axis]);
      if (!cloud.normals.empty()) normal[axis] += weights[v] * static_cast<double>(cloud.normals[v][axis]);
    }
    for (std::size_t c = 0; c < 4 && !cloud.colors.empty(); ++c) color.at(c) += weights[v] * cloud.colors[v].at(c);
  }
  raw.positions.push_back({first[0] + shift[0] / sum, first[1] + shift[1] / sum, first[2] + shift[2] / sum});
  if (!cloud.normals.empty()) {
    const double length = norm(normal);
    const auto part = [&](std::size_t axis) { return static_cast<float>(normal[axis] / length); };
    raw.normals.push_back(length > 0 ? Normal3{part(0), part(1), part(2)} : cloud.normals[points.front()]);
  }
  if (cloud.colors.empty()) return;
  Color4 mean{};
  for (std::size_t c = 0; c < 4; ++c) mean.at(c) = static_cast<std::uint8_t>(std::lround(color.at(c) / sum));
  raw.colors.push_back(mean);
}

}  // namespace

std::optional<NearRepeats> near_repeats_of(const std::vector<Point3>& positions) {
  const std::vector<std::vector<double>> distances = window_distances(positions);
  const auto gap = widest_gap(distances);
  if (!gap) return std::nullopt;
  const double limit = std::sqrt(low_end((*gap)[0] + 1) * low_end((*gap)[1]));
  std::vector<double> near;
  std::vector<double> far;
  std::size_t below = 0;
  for (const std::vector<double>& of_one : distances) {
    const auto first = std::ranges::upper_bound(of_one, limit);
    below += static_cast<std::size_t>(first - of_one.begin());
    if (first != of_one.begin()) near.push_back(of_one.front());
    if (first != of_one.end()) far.push_back(*first);
  }
  const auto queries = static_cast<double>(distances.size());
  const double sites = static_cast<double>(positions.size()) / (1 + static_cast<double>(below) / queries);
  const bool repeats = static_cast<double>(near.size()) >= kLeastBelow * queries &&
                       static_cast<double>(far.size()) >= kLeastBeyond * queries && sites >= kFewestSites;
  if (!repeats) return std::nullopt;
  return NearRepeats{.tolerance = limit,
                     .near = median(near),
                     .far = median(far),
                     .share = static_cast<double>(near.size()) / queries};
}

Result<PointCloud> fused(const PointCloud& cloud, double tolerance, Context& context) {
  return preparing::guarded<PointCloud>("fusing", context, [&]() -> Result<PointCloud> {
    std::vector<double> weights(cloud.size(), cloud.input_to_vertex.empty() ? 1 : 0);
    for (const VertexIndex v : cloud.input_to_vertex) {
      if (v.valid()) ++weights[v];
    }
    CellGrid grid(cloud.positions, tolerance);
    std::vector<bool> taken(cloud.size(), false);
    RawCloud raw;
    raw.warnings = cloud.warnings;
    for (std::size_t v = 0; v < cloud.size(); ++v) {
      if (taken[v]) continue;
      const std::vector<std::size_t> points = grid.take_near(cloud.positions[v]);
      for (const std::size_t p : points) taken[p] = true;
      push_mean(cloud, points, weights, raw);
    }
    return make_cloud(std::move(raw), context.threads());
  });
}

}  // namespace surfaced
