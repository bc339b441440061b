// SPDX-License-Identifier: GPL-3.0-or-later
// Coordinates as float32 around an origin.
#include <algorithm>
#include <cmath>
#include <limits>

#include "io/formats.hpp"

namespace surfaced::io {
namespace {

/// A larger mesh stays where it is: around another origin its coordinates could leave float32's range.
constexpr double kLargestShifted = static_cast<double>(std::numeric_limits<float>::max()) / 4;

}  // namespace

Point3 float_origin_of(const std::vector<Point3>& positions) {
  if (fits_float32(positions)) return {};
  const Bounds bounds = bounds_of(positions);
  double side = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) side = std::max(side, bounds.high[axis] - bounds.low[axis]);
  if (side > kLargestShifted) return {};
  Point3 origin{};
  int exponent = 0;
  std::frexp(side, &exponent);
  const double step = std::ldexp(1.0, exponent - 2);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double middle = bounds.low[axis] + (bounds.high[axis] - bounds.low[axis]) / 2;
    origin[axis] = side > 0 ? std::round(middle / step) * step : middle;
  }
  return origin;
}

std::array<float, 3> local_position(const Point3& position, const Point3& origin) {
  std::array<float, 3> local{};
  const bool shifted = origin != Point3{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // x - 0 would turn -0 into 0
    local.at(axis) = static_cast<float>(shifted ? position[axis] - origin[axis] : position[axis]);
  }
  return local;
}

Bytes bytes_of_text(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

}  // namespace surfaced::io

namespace surfaced {

std::vector<Point3> positions_in_stl(const TriangleMesh& mesh) {
  const Point3 origin = io::float_origin_of(mesh.positions);
  std::vector<Point3> stored;
  stored.reserve(mesh.positions.size());
  for (const Point3& p : mesh.positions) {
    const std::array<float, 3> local = io::local_position(p, origin);
    stored.push_back({static_cast<double>(local[0]) + origin[0], static_cast<double>(local[1]) + origin[1],
                      static_cast<double>(local[2]) + origin[2]});
  }
  return stored;
}

}  // namespace surfaced
