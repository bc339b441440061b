// SPDX-License-Identifier: GPL-3.0-or-later
// Small random and degenerate clouds, numbered, so that a failing one can be named and made again.
#pragma once

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "support/shapes.hpp"

namespace surfaced::testing {

struct NastyCloud {
  std::string kind;
  std::vector<Point3> points;
};

class NastyClouds {
 public:
  /// Cloud `number`; the same in every run and on every machine that has the same standard library.
  static NastyCloud make(std::uint64_t number) {
    NastyClouds maker(number);
    constexpr std::array kKinds{&NastyClouds::lattice,  &NastyClouds::uniform,      &NastyClouds::cospherical,
                                &NastyClouds::slab,     &NastyClouds::two_scales,   &NastyClouds::shells,
                                &NastyClouds::sheets,   &NastyClouds::with_repeats, &NastyClouds::curve,
                                &NastyClouds::far_away, &NastyClouds::few};
    return (maker.*kKinds[number % kKinds.size()])();
  }

 private:
  explicit NastyClouds(std::uint64_t number) : random_(static_cast<std::uint32_t>(number * 2654435761U + 12345U)) {}

  std::size_t count(std::size_t low, std::size_t high) { return low + random_() % (high - low + 1); }
  double unit() { return static_cast<double>(random_()) / 4294967296.0; }
  Point3 in_cube() { return {unit(), unit(), unit()}; }
  Point3 direction() {
    for (;;) {
      const Point3 p{2 * unit() - 1, 2 * unit() - 1, 2 * unit() - 1};
      const double length = norm(p);
      if (length > 0.1 && length < 1) return {p[0] / length, p[1] / length, p[2] / length};
    }
  }

  NastyCloud lattice() {
    NastyCloud cloud{"lattice", {}};
    const std::size_t side = count(2, 5);
    for (std::size_t n = count(6, 120); n > 0; --n) {
      cloud.points.push_back({static_cast<double>(random_() % side), static_cast<double>(random_() % side),
                              static_cast<double>(random_() % side)});
    }
    return cloud;
  }
  NastyCloud uniform() {
    NastyCloud cloud{"uniform", {}};
    for (std::size_t n = count(5, 60); n > 0; --n) cloud.points.push_back(in_cube());
    return cloud;
  }
  NastyCloud cospherical() {
    NastyCloud cloud{"cospherical", {}};
    for (std::size_t n = count(5, 50); n > 0; --n) cloud.points.push_back(direction());
    return cloud;
  }
  /// Nearly in one plane.
  NastyCloud slab() {
    NastyCloud cloud{"slab", {}};
    for (std::size_t n = count(5, 40); n > 0; --n) {
      cloud.points.push_back({unit(), unit(), 1 + 1e-12 * (unit() - 0.5)});
    }
    return cloud;
  }
  /// Clusters whose sizes differ by twelve orders of magnitude.
  NastyCloud two_scales() {
    NastyCloud cloud{"two scales", {}};
    const double small = std::pow(10.0, -static_cast<double>(count(3, 12)));
    for (std::size_t cluster = count(1, 3); cluster > 0; --cluster) {
      const Point3 centre = cluster == 1 ? Point3{0, 0, 0} : in_cube();
      for (std::size_t n = count(4, 14); n > 0; --n) {
        const Point3 d = direction();
        cloud.points.push_back({centre[0] + small * d[0], centre[1] + small * d[1], centre[2] + small * d[2]});
      }
    }
    for (std::size_t n = count(0, 12); n > 0; --n) cloud.points.push_back(in_cube());
    return cloud;
  }
  NastyCloud shells() {
    NastyCloud cloud{"nested shells", {}};
    double radius = 1;
    for (std::size_t shell = count(2, 3); shell > 0; --shell, radius *= 0.2 + 0.6 * unit()) {
      const auto points = sphere_points(count(12, 40), {0, 0, 0}, radius);
      cloud.points.insert(cloud.points.end(), points.begin(), points.end());
    }
    return cloud;
  }
  /// Parallel grids close to one another.
  NastyCloud sheets() {
    NastyCloud cloud{"sheets", {}};
    const double gap = std::pow(10.0, -3 * unit());
    const std::size_t side = count(2, 5);
    for (std::size_t layer = 0; layer < count(2, 3); ++layer) {
      for (std::size_t i = 0; i < side; ++i) {
        for (std::size_t j = 0; j < side; ++j) {
          cloud.points.push_back({static_cast<double>(i), static_cast<double>(j), gap * static_cast<double>(layer)});
        }
      }
    }
    return cloud;
  }
  NastyCloud with_repeats() {
    NastyCloud cloud = uniform();
    cloud.kind = "repeats";
    for (std::size_t n = count(1, 20); n > 0; --n)
      cloud.points.push_back(cloud.points[random_() % cloud.points.size()]);
    return cloud;
  }
  /// A closed or knotted curve: no surface comes near it.
  NastyCloud curve() {
    NastyCloud cloud{"curve", {}};
    const auto n = static_cast<double>(count(8, 60));
    const auto turns = static_cast<double>(count(1, 4));
    for (double i = 0; i < n; ++i) {
      const double t = 2 * std::numbers::pi * i / n;
      cloud.points.push_back({(2 + std::cos(turns * t)) * std::cos(2 * t), (2 + std::cos(turns * t)) * std::sin(2 * t),
                              std::sin(turns * t)});
    }
    return cloud;
  }
  /// The same shape where doubles are coarse, or tiny.
  NastyCloud far_away() {
    NastyCloud cloud = uniform();
    cloud.kind = "far away";
    const double shift = random_() % 2 == 0 ? 1e8 : 0;
    const double scale = std::ldexp(1.0, static_cast<int>(random_() % 160) - 80);
    for (Point3& p : cloud.points) {
      for (double& x : p) x = (x + shift) * scale;
    }
    return cloud;
  }
  NastyCloud few() {
    NastyCloud cloud{"few", {}};
    const std::size_t n = count(4, 8);
    const bool lattice = random_() % 2 == 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Point3 p = in_cube();
      cloud.points.push_back(lattice ? Point3{std::floor(3 * p[0]), std::floor(3 * p[1]), std::floor(3 * p[2])} : p);
    }
    return cloud;
  }

  std::mt19937 random_;
};

}  // namespace surfaced::testing
