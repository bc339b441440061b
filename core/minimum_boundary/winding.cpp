// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/winding.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kTrianglesInLeaf = 8;
/// A node farther off than this many times its radius counts as one.
constexpr double kFarOff = 2.5;

double determinant(const Point3& a, const Point3& b, const Point3& c) { return dot(a, cross(b, c)); }

}  // namespace

WindingNumber::WindingNumber(const GuidingSurface& surface) : surface_(surface) {
  if (!surface.triangles.empty()) build(0, 0, surface.triangles.size());
}

void WindingNumber::build(std::size_t node, std::size_t begin, std::size_t end) {
  if (nodes_.size() <= node) nodes_.resize(node + 1, Node{0, 0});
  Node made{begin, end};
  double weight = 0;
  for (std::size_t t = begin; t < end; ++t) {
    const auto& [a, b, c] = surface_.triangles[t];
    const Point3& p = surface_.positions[a];
    const Point3 twice = cross(surface_.positions[b] - p, surface_.positions[c] - p);
    const double size = norm(twice);
    weight += size;
    for (std::size_t i = 0; i < 3; ++i) {
      made.area[i] += twice[i] / 2;
      made.centre[i] += size * (p[i] + surface_.positions[b][i] + surface_.positions[c][i]) / 3;
    }
  }
  const Point3 first = surface_.positions[surface_.triangles[begin][0]];
  for (std::size_t i = 0; i < 3; ++i) made.centre[i] = weight > 0 ? made.centre[i] / weight : first[i];
  for (std::size_t t = begin; t < end; ++t) {
    for (const VertexIndex v : surface_.triangles[t]) {
      made.radius = std::max(made.radius, norm(surface_.positions[v] - made.centre));
    }
  }
  nodes_[node] = made;
  if (end - begin <= kTrianglesInLeaf) return;
  const std::size_t middle = begin + (end - begin) / 2;
  build(2 * node + 1, begin, middle);
  build(2 * node + 2, middle, end);
}

/// Van Oosterom and Strackee 1983.
double WindingNumber::solid_angle(std::size_t triangle, const Point3& place) const {
  const auto& [i, j, k] = surface_.triangles[triangle];
  const Point3 a = surface_.positions[i] - place;
  const Point3 b = surface_.positions[j] - place;
  const Point3 c = surface_.positions[k] - place;
  const double la = norm(a);
  const double lb = norm(b);
  const double lc = norm(c);
  return 2 * std::atan2(determinant(a, b, c), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

double WindingNumber::at(const Point3& place) const {
  if (nodes_.empty()) return 0;
  double sum = 0;
  std::vector<std::size_t> stack{0};
  while (!stack.empty()) {
    const std::size_t number = stack.back();
    stack.pop_back();
    const Node& node = nodes_[number];
    const Point3 away = node.centre - place;
    const double distance = norm(away);
    if (distance > kFarOff * node.radius) {
      sum += dot(node.area, away) / (distance * distance * distance);
    } else if (node.end - node.begin <= kTrianglesInLeaf) {
      for (std::size_t t = node.begin; t < node.end; ++t) sum += solid_angle(t, place);
    } else {
      stack.push_back(2 * number + 2);
      stack.push_back(2 * number + 1);
    }
  }
  return sum / (4 * std::numbers::pi);
}

std::vector<std::uint8_t> wound_labels(const DelaunayComplex& complex, const GuidingSurface& guide,
                                       const Context& context, unsigned threads) {
  constexpr std::size_t kCellsBetweenLooks = 1024;
  const WindingNumber winding(guide);
  std::vector<std::uint8_t> in(complex.cells(), 0);
  parallel_ranges(threads, complex.cells(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (c % kCellsBetweenLooks == 0 && context.cancelled()) return;
      if (complex.infinite(CellIndex(c))) continue;
      Point3 centroid{};
      for (std::size_t i = 0; i < 4; ++i) {
        const Point3& p = complex.positions[complex.vertex(4 * c + i)];
        for (std::size_t axis = 0; axis < 3; ++axis) centroid[axis] += p[axis] / 4;
      }
      in[c] = winding.at(centroid) > 0.5 ? 1 : 0;
    }
  });
  return in;
}

}  // namespace surfaced::boundary
