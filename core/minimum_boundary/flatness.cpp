// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/flatness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "base/float32.hpp"
#include "base/parallel.hpp"
#include "spatial/spatial.hpp"

namespace surfaced::boundary {
namespace {

/// Points no farther from a plane than this share of the distance between neighbours show no body.
constexpr double kFlatShare = 0.1;
/// Of fewer points than these every one may be a corner; then only this share is flat.
constexpr std::size_t kFewPoints = 9;
constexpr double kFlatShareOfFew = 0x1p-20;
/// Coordinates rounded to float32 lie this many steps from a plane at most.
constexpr double kRoundedSteps = 2;

/// How far the points lie from a line and from a plane through the points farthest apart.
struct Extent {
  double length = 0;
  double from_line = 0;
  double from_plane = 0;
};

template <class Distance>
std::size_t farthest(const std::vector<Point3>& points, Distance distance, double& largest) {
  std::size_t at = 0;
  largest = -1;
  for (std::size_t v = 0; v < points.size(); ++v) {
    const double d = distance(points[v]);
    if (d > largest) {
      largest = d;
      at = v;
    }
  }
  return at;
}

Extent extent_of(const std::vector<Point3>& points) {
  Extent extent;
  double unused = 0;
  const Point3 first = points.front();
  const Point3 a = points[farthest(
      points, [&](const Point3& p) { return norm(p - first); }, unused)];
  const Point3 b = points[farthest(
      points, [&](const Point3& p) { return norm(p - a); }, extent.length)];
  if (!(extent.length > 0)) return extent;
  const Point3 along = b - a;
  const auto from_line = [&](const Point3& p) { return norm(cross(along, p - a)) / extent.length; };
  const Point3 c = points[farthest(points, from_line, extent.from_line)];
  const Point3 normal = cross(along, c - a);
  const double size = norm(normal);
  if (!(size > 0)) return extent;
  farthest(
      points, [&](const Point3& p) { return std::abs(dot(normal, p - a)) / size; }, extent.from_plane);
  return extent;
}

/// Median over the points of the distance to the nearest other.
double median_gap(const std::vector<Point3>& points, unsigned threads) {
  const BoxTree tree(points, threads);
  std::vector<double> gaps(points.size());
  parallel_tasks(threads, tree.blocks(), [&](std::size_t block) {
    NeighbourSearch search(tree);
    Neighbours near;
    for (std::size_t leaf = tree.first_leaf(block); leaf < tree.first_leaf(block + 1); ++leaf) {
      search.begin_leaf(leaf, 1);
      for (std::size_t v = tree.first_point(leaf); v < tree.first_point(leaf + 1); ++v) {
        search.nearest(v, 1, near);
        gaps[v] = std::sqrt(near.distance2[0]) / tree.scale();
      }
    }
  });
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::ranges::nth_element(gaps, middle);
  return *middle;
}

/// One step of float32 at the largest coordinate; 0 if the coordinates are finer than that.
double float_step(const std::vector<Point3>& points) {
  if (!fits_float32(points)) return 0;
  float largest = 0;
  for (const Point3& p : points) {
    for (const double x : p) largest = std::max(largest, static_cast<float>(std::abs(x)));
  }
  return static_cast<double>(std::nextafter(largest, std::numeric_limits<float>::infinity())) -
         static_cast<double>(largest);
}

Error flat(ErrorCode code, std::size_t points, const char* what, double distance) {
  std::ostringstream text;
  text << "all " << points << " distinct points lie within " << distance << " of one " << what
       << ", far less than their distance from each other or no more than the steps of float32: they determine no "
          "body; local-delaunay makes open sheets";
  return {code, text.str()};
}

}  // namespace

Status refuse_flat(const PointCloud& cloud, unsigned threads) {
  const std::vector<Point3>& points = cloud.positions;
  if (points.size() < 4) return Done{};  // the triangulation says what is missing
  const Extent extent = extent_of(points);
  if (!std::isfinite(extent.length) || !(extent.from_line > 0)) return Done{};
  const double rounding = kRoundedSteps * float_step(points);
  // No more than this for points spread over a line or a plane; what is thicker needs no search.
  const auto n = static_cast<double>(points.size());
  const double share = points.size() < kFewPoints ? kFlatShareOfFew : kFlatShare;
  const bool suspect = extent.from_plane <= std::max(rounding, 2 * share * extent.length / std::sqrt(n));
  if (!suspect) return Done{};
  const double enough = std::max(rounding, share * median_gap(points, threads));
  if (extent.from_line <= enough) return flat(ErrorCode::collinear, points.size(), "line", extent.from_line);
  if (extent.from_plane <= enough) return flat(ErrorCode::coplanar, points.size(), "plane", extent.from_plane);
  return Done{};
}

}  // namespace surfaced::boundary
