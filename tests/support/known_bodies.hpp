// SPDX-License-Identifier: GPL-3.0-or-later
// Random points of bodies whose volume, genus and number of components are known, with noise.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "cloud/cloud.hpp"
#include "mesh/mesh.hpp"

namespace surfaced::testing {

struct KnownBody {
  std::string name;
  double volume;
  double area;
  std::int64_t genus;
  /// A random point of the surface.
  std::function<Point3(std::mt19937&)> point;
};

/// Independent of the standard library's distributions, so that the clouds are the same everywhere.
inline double random_unit(std::mt19937& random) { return (static_cast<double>(random()) + 0.5) / 4294967296.0; }
inline double random_normal(std::mt19937& random) {
  const double radius = std::sqrt(-2 * std::log(random_unit(random)));
  return radius * std::cos(2 * std::numbers::pi * random_unit(random));
}

inline KnownBody ellipsoid_body(std::string name, Point3 half) {
  const auto [a, b, c] = half;
  // A point of the sphere is kept in proportion to how much the map stretches the area there.
  const auto stretch = [=](const Point3& p) {
    return std::sqrt(b * b * c * c * p[0] * p[0] + a * a * c * c * p[1] * p[1] + a * a * b * b * p[2] * p[2]);
  };
  const double most = std::max({a * b, a * c, b * c});
  const auto power = [](double x) { return std::pow(x, 1.6075); };
  // Knud Thomsen's approximation, within 1.1 %.
  const double area = 4 * std::numbers::pi * std::pow((power(a * b) + power(a * c) + power(b * c)) / 3, 1 / 1.6075);
  return {std::move(name), 4 * std::numbers::pi * a * b * c / 3, area, 0, [=](std::mt19937& random) {
            for (;;) {
              const double z = 2 * random_unit(random) - 1;
              const double angle = 2 * std::numbers::pi * random_unit(random);
              const double r = std::sqrt(1 - z * z);
              const Point3 p{r * std::cos(angle), r * std::sin(angle), z};
              if (random_unit(random) * most <= stretch(p)) return Point3{a * p[0], b * p[1], c * p[2]};
            }
          }};
}

inline Point3 random_point_of_box(const Point3& low, const Point3& size, std::mt19937& random) {
  const std::array<double, 3> areas{size[1] * size[2], size[0] * size[2], size[0] * size[1]};
  double at = random_unit(random) * (areas[0] + areas[1] + areas[2]);
  std::size_t axis = 0;
  while (axis < 2 && at > areas[axis]) at -= areas[axis++];
  Point3 p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = low[i] + size[i] * random_unit(random);
  p[axis] = low[axis] + (random() % 2 == 0 ? 0 : size[axis]);
  return p;
}

inline KnownBody box_body(std::string name, Point3 size) {
  return {std::move(name), size[0] * size[1] * size[2], 2 * (size[0] * size[1] + size[0] * size[2] + size[1] * size[2]),
          0, [=](std::mt19937& random) {
            return random_point_of_box({0, 0, 0}, size, random);
          }};
}

inline KnownBody torus_body(std::string name, double tube) {
  const double pi = std::numbers::pi;
  return {std::move(name), 2 * pi * pi * tube * tube, 4 * pi * pi * tube, 1, [=](std::mt19937& random) {
            for (;;) {
              const double v = 2 * pi * random_unit(random);
              if (random_unit(random) * (1 + tube) > 1 + tube * std::cos(v)) continue;
              const double u = 2 * pi * random_unit(random);
              const double r = 1 + tube * std::cos(v);
              return Point3{r * std::cos(u), r * std::sin(u), tube * std::sin(v)};
            }
          }};
}

/// A tube around the trefoil (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t).
inline KnownBody knot_body(std::string name, double tube) {
  const auto curve = [](double t) {
    return Point3{std::sin(t) + 2 * std::sin(2 * t), std::cos(t) - 2 * std::cos(2 * t), -std::sin(3 * t)};
  };
  const auto slope = [](double t) {
    return Point3{std::cos(t) + 4 * std::cos(2 * t), -std::sin(t) + 4 * std::sin(2 * t), -3 * std::cos(3 * t)};
  };
  const double pi = std::numbers::pi;
  constexpr int kSteps = 1000;
  double length = 0;
  for (int k = 0; k < kSteps; ++k) length += norm(slope(2 * pi * k / kSteps)) * 2 * pi / kSteps;
  return {std::move(name), pi * tube * tube * length, 2 * pi * tube * length, 1, [=](std::mt19937& random) {
            for (;;) {
              const double t = 2 * pi * random_unit(random);
              const Point3 along = slope(t);
              const double speed = norm(along);
              if (random_unit(random) * 6 > speed) continue;
              const Point3 side = cross(along, {0, 0, 1});
              const Point3 up = cross(side, along);
              const double angle = 2 * pi * random_unit(random);
              Point3 p = curve(t);
              for (std::size_t i = 0; i < 3; ++i) {
                p[i] += tube * (std::cos(angle) * side[i] / norm(side) + std::sin(angle) * up[i] / norm(up));
              }
              return p;
            }
          }};
}

/// An L: 2 x 1 x 2 without its upper right quarter.
inline KnownBody bracket_body() {
  const double leg = 0.6;
  const auto inside = [=](const Point3& p, const Point3& size) {
    return p[0] < size[0] && p[2] < size[2] && p[0] > 0 && p[2] > 0;
  };
  return {"bracket", leg * 2 + leg * (2 - leg), 2 * (2 * leg + leg * (2 - leg)) + 2 + 2 + 2 * leg + 2 * (2 - leg), 0,
          [=](std::mt19937& random) {
            const Point3 lying{2, 1, leg};
            const Point3 standing{leg, 1, 2};
            for (;;) {
              // Both boxes have the same area; what lies within the other one, or twice, does not count.
              const bool first = random() % 2 == 0;
              const Point3 p = random_point_of_box({0, 0, 0}, first ? lying : standing, random);
              if (inside(p, first ? standing : lying)) continue;
              const bool shared = (p[0] == 0 && p[2] < leg) || (p[2] == 0 && p[0] < leg) ||
                                  ((p[1] == 0 || p[1] == 1) && p[0] < leg && p[2] < leg);
              if (shared && !first) continue;
              return p;
            }
          }};
}

/// A box 2 x 2 x 0.8 with a round tunnel of radius 0.5.
inline KnownBody drilled_body() {
  const double radius = 0.5;
  const double height = 0.8;
  const double pi = std::numbers::pi;
  const double wall = 2 * pi * radius * height;
  const double box = 8 + 8 * height;
  return {"drilled box", 4 * height - pi * radius * radius * height, box - 2 * pi * radius * radius + wall, 1,
          [=](std::mt19937& random) {
            for (;;) {
              if (random_unit(random) * (box + wall) < wall) {
                const double angle = 2 * pi * random_unit(random);
                return Point3{1 + radius * std::cos(angle), 1 + radius * std::sin(angle), height * random_unit(random)};
              }
              const Point3 p = random_point_of_box({0, 0, 0}, {2, 2, height}, random);
              const bool in_tunnel = std::hypot(p[0] - 1, p[1] - 1) < radius;
              if (!in_tunnel) return p;
            }
          }};
}

inline std::vector<KnownBody> known_bodies() {
  return {ellipsoid_body("ball", {1, 1, 1}),
          ellipsoid_body("ellipsoid", {1, 0.7, 0.45}),
          box_body("box", {2, 1.4, 1}),
          box_body("plate", {2, 1.6, 0.4}),
          torus_body("torus", 0.3),
          torus_body("thick torus", 0.5),
          knot_body("knot", 0.35),
          bracket_body(),
          drilled_body()};
}

/// n points, each coordinate moved by a normal deviate of `noise` spacings; the spacing is √(area / n).
inline std::vector<Point3> points_of(const KnownBody& body, std::size_t n, double noise, std::uint32_t seed) {
  std::mt19937 random(seed);
  const double size = noise * std::sqrt(body.area / static_cast<double>(n));
  std::vector<Point3> points;
  for (std::size_t k = 0; k < n; ++k) {
    Point3 p = body.point(random);
    for (double& x : p) x += size * random_normal(random);
    points.push_back(p);
  }
  return points;
}

inline double volume_of(const TriangleMesh& mesh) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    sum += dot(mesh.positions[t[0]], cross(mesh.positions[t[1]], mesh.positions[t[2]]));
  }
  return sum / 6;
}

}  // namespace surfaced::testing
