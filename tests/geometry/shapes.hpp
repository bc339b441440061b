// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds that are hard on geometry code: many points on a line, in a plane or on a sphere, coincident up to a rounding,
// of very different distances, of extreme extents.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "base/vectors.hpp"
#include "geometry/choices.hpp"

namespace surfaced::testing::shapes {

using Points = std::vector<Point3>;

inline Point3 in_cube(Numbers& numbers) {
  return {numbers.between(-1, 1), numbers.between(-1, 1), numbers.between(-1, 1)};
}

inline Points uniform(std::size_t n, Numbers& numbers) {
  Points points;
  while (points.size() < n) points.push_back(in_cube(numbers));
  return points;
}

/// Integers: many in one plane, on one line, on one sphere, and the same twice.
inline Points lattice(std::size_t n, Numbers& numbers) {
  const std::size_t side = 2 + numbers.below(8);
  const auto coordinate = [&] { return static_cast<double>(numbers.below(side)); };
  Points points;
  while (points.size() < n) points.push_back({coordinate(), coordinate(), coordinate()});
  return points;
}

/// Rings of latitude, in double: the points of the polar rings differ by roundings.
inline Points latitudes(std::size_t n, Numbers& numbers) {
  const std::size_t around = 3 + numbers.below(2 + n / 3);
  const std::size_t rings = std::max<std::size_t>(2, n / around);
  Points points;
  for (std::size_t i = 0; i < rings; ++i) {
    const double theta = std::numbers::pi * static_cast<double>(i) / static_cast<double>(rings - 1);
    for (std::size_t j = 0; j < around; ++j) {
      const double phi = 2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(around);
      points.push_back({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
    }
  }
  return points;
}

inline Points spiral(std::size_t n, Numbers& /*numbers*/) {
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const double z = 1 - 2 * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    const double r = std::sqrt(1 - z * z);
    points.push_back({r * std::cos(golden * static_cast<double>(i)), r * std::sin(golden * static_cast<double>(i)), z});
  }
  return points;
}

/// A line and up to three points beside it.
inline Points line(std::size_t n, Numbers& numbers) {
  const Point3 step = numbers.below(2) == 0 ? Point3{1, 0, 0} : Point3{1, 2, 3};
  Points points;
  for (std::size_t i = 0; i < n; ++i) points.push_back(static_cast<double>(i) * step);
  for (std::size_t i = numbers.below(4); i > 0; --i) points.push_back(static_cast<double>(n) * in_cube(numbers));
  return points;
}

/// Two lines across each other: every point of one is joined to every one of the other.
inline Points two_lines(std::size_t n, Numbers& /*numbers*/) {
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(n);
    points.push_back(i % 2 == 0 ? Point3{t, 0, 0} : Point3{0.5, t - 0.5, 1});
  }
  return points;
}

inline Points sheet(std::size_t n, Numbers& numbers) {
  const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(n))));
  const bool even = numbers.below(2) == 0;
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    points.push_back(even ? Point3{static_cast<double>(i % side), static_cast<double>(i / side), 0}
                          : Point3{numbers.between(-1, 1), numbers.between(-1, 1), 0});
  }
  return points;
}

inline Points circles(std::size_t n, Numbers& numbers) {
  const std::size_t circles = 1 + numbers.below(4);
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const double a =
        2 * std::numbers::pi * static_cast<double>(i / circles) * static_cast<double>(circles) / static_cast<double>(n);
    points.push_back({std::cos(a), std::sin(a), static_cast<double>(i % circles)});
  }
  return points;
}

/// Points that differ by the last bits of their coordinates.
inline Points roundings(std::size_t n, Numbers& numbers) {
  const Point3 centre = numbers.below(2) == 0 ? Point3{1, 1, 1} : in_cube(numbers);
  Points points;
  while (points.size() < n) {
    Point3 p = centre;
    for (std::size_t step = numbers.below(6); step > 0; --step) {
      double& x = p.at(numbers.below(3));
      x = std::nextafter(x, std::numeric_limits<double>::max());
    }
    points.push_back(p);
  }
  return points;
}

/// The moment curve, at whose points a Delaunay triangulation has a quadratic number of cells.
inline Points curve(std::size_t n, Numbers& /*numbers*/) {
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i + 1) / static_cast<double>(n);
    points.push_back({t, t * t, t * t * t});
  }
  return points;
}

/// Coordinates of any magnitude that a cloud may have.
inline Points magnitudes(std::size_t n, Numbers& numbers) {
  const double least = numbers.below(2) == 0 ? -1000 : -20;
  const double greatest = numbers.below(2) == 0 ? 127 : 0;
  const auto coordinate = [&] {
    const double x = std::exp2(std::floor(numbers.between(least, greatest))) * numbers.between(1, 1.9);
    return numbers.below(2) == 0 ? x : -x;
  };
  Points points;
  while (points.size() < n) points.push_back({coordinate(), coordinate(), coordinate()});
  return points;
}

/// Nearer and nearer to one point.
inline Points towards_a_point(std::size_t n, Numbers& numbers) {
  const double shrinking = numbers.below(2) == 0 ? 0.5 : 0.9;
  Points points;
  double size = 1;
  for (std::size_t i = 0; i < n; ++i, size *= shrinking) points.push_back(size * in_cube(numbers));
  return points;
}

inline Points torus(std::size_t n, Numbers& numbers) {
  Points points;
  while (points.size() < n) {
    const double u = 2 * std::numbers::pi * numbers.unit();
    const double v = 2 * std::numbers::pi * numbers.unit();
    const double r = 1 + 0.4 * std::cos(v);
    points.push_back({r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)});
  }
  return points;
}

/// On the six sides of a cube.
inline Points box(std::size_t n, Numbers& numbers) {
  Points points;
  while (points.size() < n) {
    Point3 p = in_cube(numbers);
    p.at(numbers.below(3)) = numbers.below(2) == 0 ? -1 : 1;
    points.push_back(p);
  }
  return points;
}

inline constexpr std::array kAll{&uniform,    &lattice,         &latitudes, &spiral,    &line,
                                 &two_lines,  &sheet,           &circles,   &roundings, &curve,
                                 &magnitudes, &towards_a_point, &torus,     &box};

}  // namespace surfaced::testing::shapes
