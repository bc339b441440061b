// SPDX-License-Identifier: GPL-3.0-or-later
#include "cloud/measurements.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

namespace surfaced {
namespace {

constexpr double kFloatMax = static_cast<double>(std::numeric_limits<float>::max());

/// So many points at 0 0 0, and so large a share, are no chance.
constexpr std::size_t kFewestZeros = 10;
constexpr std::size_t kZerosOneIn = 1000;
/// How many neighbours of the origin are looked at.
constexpr std::size_t kMostNeighbours = 64;
constexpr std::size_t kFewestNeighbours = 8;
/// The neighbours of a place off a surface are all about as far as the nearest of them; the neighbours of a place on it
/// are not: of a grid with spacing s the eighth is 1.4 s away, of points at random farther still.
constexpr double kOffWithin = 1.25;
/// A place so many spacings of its neighbours away from the nearest of them is not among them.
constexpr double kOffSpacings = 6;
/// Points of a ring are about as far from its pole; the next ring is twice as far.
constexpr double kRing = 1.05;
constexpr double kNextRing = 1.5;

/// The shortest text that is this value.
std::string value_text(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

bool is_finite(const Point3& p) { return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]); }

/// What one pass over the coordinates finds.
struct Found {
  std::size_t not_finite = 0;
  std::size_t zeros = 0;
  /// First point with a coordinate that no mesh file could hold.
  std::optional<std::size_t> first_not_finite;
  std::optional<std::size_t> first_too_large;
};

Found look_through(std::vector<Point3>& positions) {
  Found found;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    Point3& p = positions[i];
    if (std::abs(p[0]) <= kFloatMax && std::abs(p[1]) <= kFloatMax && std::abs(p[2]) <= kFloatMax) {
      for (double& x : p) x += 0.0;
      found.zeros += p == Point3{} ? 1U : 0U;
    } else if (is_finite(p)) {
      if (!found.first_too_large) found.first_too_large = i;
    } else {
      ++found.not_finite;
      if (!found.first_not_finite) found.first_not_finite = i;
    }
  }
  return found;
}

std::string where(const Point3& p, std::size_t point, const auto& bad) {
  const auto axis = static_cast<std::size_t>(std::ranges::find_if(p, bad) - p.begin());
  return "point " + std::to_string(point) + ": " + "xyz"[axis] + " = " + value_text(p[axis]);
}

Error too_large(const Point3& p, std::size_t point) {
  return {ErrorCode::coordinate_out_of_range, where(p, point, [](double x) { return std::abs(x) > kFloatMax; }) +
                                                  " exceeds the largest float32, " + value_text(kFloatMax)};
}

Error not_finite(const RawCloud& raw, const Found& found, Missing missing) {
  std::string detail = where(raw.positions[*found.first_not_finite], *found.first_not_finite,
                             [](double x) { return !std::isfinite(x); }) +
                       " is not a finite number, and so are coordinates of " + std::to_string(found.not_finite) +
                       " of " + std::to_string(raw.size()) + " points";
  if (missing == Missing::refuse) detail += "; missing=drop leaves them out";
  return {ErrorCode::coordinate_not_finite, detail};
}

/// Median over the points of the distance to the nearest other.
double spacing_among(const std::vector<Point3>& points) {
  std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      const double distance = norm(points[i] - points[j]);
      if (distance > 0) nearest[i] = std::min(nearest[i], distance);
    }
  }
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::ranges::nth_element(nearest, middle);
  return *middle;
}

/// Whether the origin is the pole of rings of points, each as far from the next as the first from the pole: a grid of
/// angles has as many points there as in a ring.
bool is_pole(const std::vector<Point3>& others) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Point3& p : others) nearest = std::min(nearest, norm(p));
  double next = std::numeric_limits<double>::infinity();
  for (const Point3& p : others) {
    if (const double distance = norm(p); distance > kRing * nearest) next = std::min(next, distance);
  }
  return std::isfinite(next) && next >= kNextRing * nearest;
}

/// Whether the origin lies off all points that are not there.
bool origin_is_off(const std::vector<Point3>& positions) {
  std::vector<Point3> others;
  others.reserve(positions.size());
  for (const Point3& p : positions) {
    if (is_finite(p) && p != Point3{}) others.push_back(p);
  }
  const std::size_t count = std::clamp(others.size() / 8, kFewestNeighbours, kMostNeighbours);
  if (others.size() < count || is_pole(others)) return false;
  const auto nearer = [](const Point3& a, const Point3& b) {
    return std::pair(norm(a), a) < std::pair(norm(b), b);  // of equals the same ones for any order
  };
  std::ranges::partial_sort(others, others.begin() + static_cast<std::ptrdiff_t>(count), nearer);
  others.resize(count);
  const double nearest = norm(others.front());
  return norm(others.back()) <= kOffWithin * nearest || nearest >= kOffSpacings * spacing_among(others);
}

/// Corners of a mesh come several times each, also where one is the origin; points of a scan do not.
bool zeros_are_missing(const RawCloud& raw, std::size_t zeros) {
  return raw.source.faces == 0 && zeros >= kFewestZeros && zeros >= raw.size() / kZerosOneIn &&
         origin_is_off(raw.positions);
}

std::vector<std::uint32_t> keep(RawCloud& raw, bool zeros_too) {
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const Point3& p = raw.positions[i];
    if (!is_finite(p) || (!zeros_too && p == Point3{})) continue;
    const std::size_t to = kept.size();
    raw.positions[to] = p;
    if (!raw.normals.empty()) raw.normals[to] = raw.normals[i];
    if (!raw.colors.empty()) raw.colors[to] = raw.colors[i];
    kept.push_back(static_cast<std::uint32_t>(i));
  }
  raw.positions.resize(kept.size());
  if (!raw.normals.empty()) raw.normals.resize(kept.size());
  if (!raw.colors.empty()) raw.colors.resize(kept.size());
  return kept;
}

}  // namespace

Result<std::vector<std::uint32_t>> keep_measured(RawCloud& raw, Missing missing) {
  const Found found = look_through(raw.positions);
  if (found.first_too_large) return too_large(raw.positions[*found.first_too_large], *found.first_too_large);
  if (found.not_finite > 0 && (missing == Missing::refuse || found.not_finite == raw.size())) {
    return not_finite(raw, found, missing);
  }
  const bool drop_zeros = missing == Missing::drop && zeros_are_missing(raw, found.zeros);
  if (found.not_finite == 0 && !drop_zeros) return std::vector<std::uint32_t>{};
  const std::string of = " of " + std::to_string(raw.size()) + " points ";
  if (found.not_finite > 0) {
    raw.warnings.push_back(std::to_string(found.not_finite) + of +
                           "left out: they have no measurement (a coordinate is NaN or infinite)");
  }
  if (drop_zeros) {
    raw.warnings.push_back(std::to_string(found.zeros) + of +
                           "left out: they lie at exactly 0 0 0, off all others, as depth cameras write what they did "
                           "not measure; missing=refuse keeps them as points");
  }
  return keep(raw, !drop_zeros);
}

}  // namespace surfaced
