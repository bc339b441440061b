// SPDX-License-Identifier: GPL-3.0-or-later
// Generated shapes whose topology is known.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "cloud/cloud.hpp"
#include "mesh/mesh.hpp"

namespace surfaced::testing {

inline RawCloud raw_cloud(std::vector<Point3> positions) {
  RawCloud raw;
  raw.positions = std::move(positions);
  return raw;
}

/// Nearly even points on the unit sphere: a Fibonacci spiral.
inline std::vector<Point3> sphere_points(std::size_t n, Point3 centre = {0, 0, 0}, double radius = 1) {
  std::vector<Point3> points;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (std::size_t i = 0; i < n; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(n);
    const double r = std::sqrt(1 - z * z);
    const double angle = golden * static_cast<double>(i);
    points.push_back(
        {centre[0] + radius * r * std::cos(angle), centre[1] + radius * r * std::sin(angle), centre[2] + radius * z});
  }
  return points;
}

/// around x along grid points on a torus with radii 1 and `tube`.
inline std::vector<Point3> torus_points(std::size_t around, std::size_t along, double tube = 0.3) {
  std::vector<Point3> points;
  for (std::size_t i = 0; i < around; ++i) {
    for (std::size_t j = 0; j < along; ++j) {
      const double u = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(around);
      const double v = 2 * std::numbers::pi * (static_cast<double>(j) + 0.5 * static_cast<double>(i % 2)) /
                       static_cast<double>(along);
      const double r = 1 + tube * std::cos(v);
      points.push_back({r * std::cos(u), r * std::sin(u), tube * std::sin(v)});
    }
  }
  return points;
}

/// Points of a torus with radii 1 and 0.3, random angles, the tube with noise.
inline std::vector<Point3> random_torus(std::size_t n, std::uint32_t seed, double noise = 0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
  std::normal_distribution<double> off(0, 1);
  std::vector<Point3> points;
  for (std::size_t i = 0; i < n; ++i) {
    const double u = angle(random);
    const double v = angle(random);
    const double tube = 0.3 + noise * off(random);
    points.push_back(
        {(1 + tube * std::cos(v)) * std::cos(u), (1 + tube * std::cos(v)) * std::sin(u), tube * std::sin(v)});
  }
  return points;
}

inline std::vector<Point3> random_points(std::size_t n, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  std::vector<Point3> points(n);
  for (Point3& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
  return points;
}

inline Triangle triangle(std::size_t a, std::size_t b, std::size_t c) {
  return {VertexIndex(a), VertexIndex(b), VertexIndex(c)};
}

/// Regular tetrahedron facing outwards.
inline TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.positions = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  mesh.triangles = {triangle(0, 1, 2), triangle(0, 3, 1), triangle(0, 2, 3), triangle(1, 3, 2)};
  return mesh;
}

/// Torus as a grid of around x along quads, each split in two; genus 1.
inline TriangleMesh torus_mesh(std::size_t around, std::size_t along) {
  TriangleMesh mesh;
  const auto vertex = [&](std::size_t i, std::size_t j) { return (i % around) * along + j % along; };
  for (std::size_t i = 0; i < around; ++i) {
    for (std::size_t j = 0; j < along; ++j) {
      const double u = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(around);
      const double v = 2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(along);
      mesh.positions.push_back(
          {(1 + 0.3 * std::cos(v)) * std::cos(u), (1 + 0.3 * std::cos(v)) * std::sin(u), 0.3 * std::sin(v)});
      mesh.triangles.push_back(triangle(vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)));
      mesh.triangles.push_back(triangle(vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)));
    }
  }
  return mesh;
}

/// Appends b to a as a separate part.
inline TriangleMesh together(TriangleMesh a, const TriangleMesh& b, Point3 shift) {
  const std::size_t offset = a.positions.size();
  for (const Point3& p : b.positions) a.positions.push_back({p[0] + shift[0], p[1] + shift[1], p[2] + shift[2]});
  for (const Triangle& t : b.triangles) a.triangles.push_back(triangle(t[0] + offset, t[1] + offset, t[2] + offset));
  return a;
}

}  // namespace surfaced::testing
