// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/ball_ratio.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"

namespace surfaced::boundary {
namespace {

/// Where a ball is too flat for its centre to be computed: neither merged early nor kept apart.
constexpr float kNeutral = 1;

}  // namespace

BallRatio::BallRatio(const DelaunayComplex& complex, unsigned threads) : complex_(complex), balls_(complex.cells()) {
  parallel_ranges(threads, complex.cells(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      if (complex.infinite(CellIndex(c))) continue;
      const Point3& o = complex.positions[complex.vertex(4 * c)];
      const Point3 a = complex.positions[complex.vertex(4 * c + 1)] - o;
      const Point3 b = complex.positions[complex.vertex(4 * c + 2)] - o;
      const Point3 d = complex.positions[complex.vertex(4 * c + 3)] - o;
      const Point3 bd = cross(b, d);
      const Point3 da = cross(d, a);
      const Point3 ab = cross(a, b);
      const double factor = 0.5 / dot(a, bd);
      const double aa = dot(a, a);
      const double bb = dot(b, b);
      const double dd = dot(d, d);
      Point3 centre{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        centre[axis] = (aa * bd[axis] + bb * da[axis] + dd * ab[axis]) * factor;
      }
      balls_[c] = {static_cast<float>(o[0] + centre[0]), static_cast<float>(o[1] + centre[1]),
                   static_cast<float>(o[2] + centre[2]), static_cast<float>(norm(centre))};
      if (!std::isfinite(balls_[c].radius)) balls_[c].radius = std::numeric_limits<float>::infinity();
    }
  });
}

float BallRatio::against_hull(SideIndex infinite_side) const {
  const SideIndex inner = complex_.mate(infinite_side);
  const Ball& ball = balls_[inner / 4];
  if (!std::isfinite(ball.radius)) return kNeutral;
  const auto facet = complex_.outward_facet(inner);
  const Point3& o = complex_.positions[facet[0]];
  const Point3 normal = cross(complex_.positions[facet[1]] - o, complex_.positions[facet[2]] - o);
  const Point3 centre{static_cast<double>(ball.x), static_cast<double>(ball.y), static_cast<double>(ball.z)};
  const double depth = -dot(centre - o, normal) / norm(normal);
  const double ratio = 1 - depth / static_cast<double>(ball.radius);
  return std::isfinite(ratio) ? std::clamp(static_cast<float>(ratio), 0.0F, 2.0F) : kNeutral;
}

float BallRatio::of(SideIndex s) const {
  const SideIndex mate = complex_.mate(s);
  const bool infinite = complex_.infinite(CellIndex(s / 4));
  const bool mate_infinite = complex_.infinite(CellIndex(mate / 4));
  if (infinite && mate_infinite) return 2;
  if (infinite) return against_hull(s);
  if (mate_infinite) return against_hull(mate);
  const Ball& p = balls_[s / 4];
  const Ball& q = balls_[mate / 4];
  const float x = p.x - q.x;
  const float y = p.y - q.y;
  const float z = p.z - q.z;
  const float distance = std::sqrt(x * x + y * y + z * z);
  const float ratio = (p.radius + q.radius - distance) / std::min(p.radius, q.radius);
  return std::isfinite(ratio) ? std::clamp(ratio, 0.0F, 2.0F) : kNeutral;
}

}  // namespace surfaced::boundary
