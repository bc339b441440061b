// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>

#include "preparing/preparing.hpp"

namespace surfaced {
namespace {

/// Fewer points may lie on a grid by chance.
constexpr std::size_t kFewestPoints = 16;
/// How far from a step a coordinate may lie, in steps: text rounds to digits of its own.
constexpr double kSlack = 0.125;
/// Steps below this share of the spacing do no harm.
constexpr double kHarmless = 1.0 / 32;

/// Decimals that are looked for in coordinates of a text, and how far from one a double may lie, in steps.
constexpr int kMostDecimals = 9;
constexpr double kDecimalSlack = 1e-4;
/// Rounding moves a point, and the ends of the line, by half a step of every axis each; along the line, too.
constexpr double kLineSteps = 2;
/// What is shorter, in steps, may be a body of few steps' thickness.
constexpr double kLeastLine = 1000;

/// The step of float32 at this magnitude.
double step_at(double magnitude) {
  int exponent = 0;
  std::frexp(magnitude, &exponent);
  return std::ldexp(1.0, exponent - std::numeric_limits<float>::digits);
}

/// Whether all coordinates are multiples of the step, and not all of twice the step, as whole numbers would be.
bool lies_on_steps(const std::vector<Point3>& positions, std::size_t axis, double step) {
  bool odd = false;
  for (const Point3& p : positions) {
    const double steps = p[axis] / step;
    const double whole = std::round(steps);
    if (!(std::abs(steps - whole) <= kSlack)) return false;
    odd |= std::fmod(whole, 2) != 0;
  }
  return odd;
}

}  // namespace

std::optional<FloatSteps> float_steps_of(const std::vector<Point3>& positions, unsigned threads) {
  if (positions.size() < kFewestPoints) return std::nullopt;
  const Bounds bounds = bounds_of(positions);
  // Of a surface; enough to leave out clouds whose steps are far too small to matter.
  const double about = bounds.diagonal() / std::sqrt(static_cast<double>(positions.size()));
  double step = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double least = bounds.low[axis] > 0 ? bounds.low[axis] : bounds.high[axis] < 0 ? -bounds.high[axis] : 0;
    const double here = least > 0 ? step_at(least) : 0;
    if (here <= step || here < kHarmless / 16 * about || !lies_on_steps(positions, axis, here)) continue;
    step = here;
  }
  if (step == 0) return std::nullopt;
  const double spacing = spacing_of(positions, threads);
  if (step < kHarmless * spacing) return std::nullopt;
  return FloatSteps{.step = step, .spacing = spacing};
}

namespace {

/// How finely every axis is rounded: to float32, or to a number of decimals; none if to neither.
std::optional<Point3> rounding_of(const std::vector<Point3>& positions) {
  const Bounds bounds = bounds_of(positions);
  const auto all = [&](const auto& is) {
    return std::ranges::all_of(positions, [&](const Point3& p) { return std::ranges::all_of(p, is); });
  };
  if (all([](double x) { return static_cast<double>(static_cast<float>(x)) == x; })) {
    Point3 steps{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      steps[axis] = step_at(std::max(std::abs(bounds.low[axis]), std::abs(bounds.high[axis])));
    }
    return steps;
  }
  for (int decimals = 0; decimals <= kMostDecimals; ++decimals) {
    const double scale = std::pow(10.0, decimals);
    if (all([scale](double x) { return std::abs(x * scale - std::round(x * scale)) <= kDecimalSlack; })) {
      return Point3{1 / scale, 1 / scale, 1 / scale};
    }
  }
  return std::nullopt;
}

}  // namespace

bool on_a_rounded_line(const std::vector<Point3>& positions) {
  if (positions.size() < 3) return false;
  const Bounds bounds = bounds_of(positions);
  const Point3 extent = bounds.high - bounds.low;
  const auto longest = static_cast<std::size_t>(std::ranges::max_element(extent) - extent.begin());
  const auto along = [longest](const Point3& a, const Point3& b) { return a[longest] < b[longest]; };
  const auto [first, last] = std::ranges::minmax_element(positions, along);
  const Point3 direction = *last - *first;
  const auto is_line = [&, from = *first](const Point3& tolerance) {
    return std::ranges::all_of(positions, [&](const Point3& p) {
      const double share = (p[longest] - from[longest]) / direction[longest];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!(std::abs(p[axis] - from[axis] - share * direction[axis]) <= tolerance[axis])) return false;
      }
      return true;
    });
  };
  const double most = kLineSteps * extent[longest] / kLeastLine;
  if (!is_line({most, most, most})) return false;
  const std::optional<Point3> steps = rounding_of(positions);
  if (!steps || !(extent[longest] >= kLeastLine * std::ranges::max(*steps))) return false;
  Point3 tolerance{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double slope = std::abs(direction[axis] / direction[longest]);
    tolerance[axis] = kLineSteps * ((*steps)[axis] + slope * (*steps)[longest]);
  }
  return is_line(tolerance);
}

}  // namespace surfaced
