// SPDX-License-Identifier: GPL-3.0-or-later
#include "intrinsic_delaunay/curvature.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "fitting/fitting.hpp"

namespace surfaced::idt {
namespace {

/// A quadric has six coefficients; twice as many points average noise out.
constexpr std::size_t kFewestPoints = 6;
constexpr std::size_t kEnoughPoints = 13;
constexpr std::size_t kMostPoints = 64;

/// The vertex and the rings around it until there are enough points; breadth first.
void rings(const Adjacency& adjacency, std::uint32_t v, std::vector<std::uint32_t>& found) {
  found.assign(1, v);
  std::size_t begin = 0;
  while (found.size() < kEnoughPoints && begin < found.size()) {
    const std::size_t end = found.size();
    for (std::size_t i = begin; i < end; ++i) {
      for (const std::uint32_t w : adjacency.of(found[i])) {
        if (found.size() == kMostPoints) return;
        if (std::ranges::find(found, w) == found.end()) found.push_back(w);
      }
    }
    begin = end;
  }
}

/// Relative to the vertex, in units of the mean distance: far origins and tiny units cost no digits.
double curvature_at(std::span<const Point3> positions, std::span<const std::uint32_t> near,
                    std::vector<Point3>& points) {
  const Point3& centre = positions[near.front()];
  double mean = 0;
  for (const std::uint32_t w : near) mean += norm(positions[w] - centre);
  mean /= static_cast<double>(near.size() - 1);
  if (!(mean > 0)) return -1;
  points.clear();
  for (const std::uint32_t w : near) {
    const Point3 d = positions[w] - centre;
    points.push_back({d[0] / mean, d[1] / mean, d[2] / mean});
  }
  const auto principal = principal_curvatures(points);
  if (!principal) return -1;
  const double largest = std::max(std::abs((*principal)[0]), std::abs((*principal)[1]));
  return std::isfinite(largest) ? largest / mean : -1;
}

/// Across an edge, which is 2ε long at most, normals turn by a quarter where ε ≤ 1/(8κ); twice that is no error of a
/// normal any more.
constexpr double kTurned = 0.5;

/// How fast the normal turns from the vertex to those neighbours where it has turned far: no faster than the surface
/// bends. A quadric over too few points around a tube knows less, in the end nothing.
double turning_at(std::span<const Point3> positions, std::span<const Point3> normals, const Adjacency& adjacency,
                  std::uint32_t v) {
  double fastest = 0;
  for (const std::uint32_t w : adjacency.of(v)) {
    const double turned = norm(normals[w] - normals[v]);
    const double rate = turned / norm(positions[w] - positions[v]);
    if (turned > kTurned && std::isfinite(rate)) fastest = std::max(fastest, rate);
  }
  return fastest;
}

}  // namespace

Adjacency adjacency_of(std::span<const Triangle> triangles, std::size_t vertices) {
  Adjacency a;
  a.first.assign(vertices + 1, 0);
  for (const Triangle& t : triangles) {
    for (const VertexIndex v : t) a.first[v + 1] += 2;
  }
  for (std::size_t v = 0; v < vertices; ++v) a.first[v + 1] += a.first[v];
  a.neighbours.resize(a.first[vertices]);
  std::vector<std::uint32_t> at(a.first.begin(), a.first.end() - 1);
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      a.neighbours[at[t[i]]++] = t[(i + 1) % 3].value;
      a.neighbours[at[t[i]]++] = t[(i + 2) % 3].value;
    }
  }
  std::uint32_t kept = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto begin = a.neighbours.begin() + static_cast<std::ptrdiff_t>(a.first[v]);
    const auto end = a.neighbours.begin() + static_cast<std::ptrdiff_t>(a.first[v + 1]);
    std::sort(begin, end);
    const auto last = std::unique(begin, end);
    a.first[v] = kept;
    std::copy(begin, last, a.neighbours.begin() + static_cast<std::ptrdiff_t>(kept));
    kept += static_cast<std::uint32_t>(last - begin);
  }
  a.first[vertices] = kept;
  a.neighbours.resize(kept);
  return a;
}

std::vector<double> curvatures(std::span<const Point3> positions, std::span<const Point3> normals,
                               const Adjacency& adjacency, Context& context) {
  std::vector<double> result(positions.size(), -1);
  parallel_ranges(context.threads(), positions.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> near;
    std::vector<Point3> points;
    for (std::size_t v = begin; v < end; ++v) {
      if (context.cancelled()) return;
      rings(adjacency, static_cast<std::uint32_t>(v), near);
      if (near.size() < kFewestPoints) continue;
      result[v] = curvature_at(positions, near, points);
      if (result[v] < 0) continue;
      result[v] = std::max(result[v], turning_at(positions, normals, adjacency, static_cast<std::uint32_t>(v)));
    }
  });
  return result;
}

}  // namespace surfaced::idt
