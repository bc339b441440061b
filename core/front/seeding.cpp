// SPDX-License-Identifier: GPL-3.0-or-later
#include "front/seeding.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace surfaced::front {
namespace {

/// Whether none of the vertices lies in the smallest ball through the corners of the face.
bool ball_is_empty(const Places& places, const Face& f, std::span<const std::uint32_t> vertices) {
  const Point3 a = places.position(f[0]);
  const Point3 b = places.position(f[1]) - a;
  const Point3 c = places.position(f[2]) - a;
  const Point3 n = cross(b, c);
  const double n2 = dot(n, n);
  if (!(n2 > 0)) return false;
  const Point3 bn = cross(n, b);
  const Point3 nc = cross(c, n);
  Point3 centre{};
  for (std::size_t i = 0; i < 3; ++i) centre[i] = (dot(c, c) * bn[i] + dot(b, b) * nc[i]) / (2 * n2);
  const double r2 = dot(centre, centre);
  return std::ranges::none_of(vertices, [&](std::uint32_t v) {
    if (std::ranges::find(f, v) != f.end()) return false;
    const Point3 d = places.position(v) - a - centre;
    return dot(d, d) < r2;
  });
}

/// Turned so that it faces where the normals of its vertices point.
Face facing_normals(const Places& places, Face f) {
  const Point3 n = area_normal(places, f);
  double agreement = 0;
  for (const std::uint32_t v : f) agreement += dot(n, places.normal(v));
  if (agreement < 0) std::swap(f[1], f[2]);
  return f;
}

}  // namespace

bool surface_is_near(const Fans& fans, Places& places, std::uint32_t v) {
  if (fans.around(v) != Around::nothing) return true;
  constexpr std::size_t kNear = 8;
  std::vector<std::pair<double, std::uint32_t>> near;
  for (const std::uint32_t w : places.neighbours(v))
    near.emplace_back(norm(places.position(w) - places.position(v)), w);
  std::ranges::sort(near);
  near.resize(std::min(near.size(), kNear));
  return std::ranges::any_of(near, [&](const auto& n) { return fans.around(n.second) != Around::nothing; });
}

bool seed_triangle(Fans& fans, Places& places, std::uint32_t v) {
  if (surface_is_near(fans, places, v)) return false;
  const auto list = places.neighbours(v);
  std::vector<std::uint32_t> near(list.begin(), list.end());
  std::uint32_t second = kNoVertex;
  double least = std::numeric_limits<double>::infinity();
  for (const std::uint32_t w : near) {
    const double distance = norm(places.position(w) - places.position(v));
    if (fans.around(w) != Around::nothing || !(distance < least)) continue;
    least = distance;
    second = w;
  }
  if (second == kNoVertex || !places.short_enough(v, second)) return false;
  Face best{};
  double radius = std::numeric_limits<double>::infinity();
  for (const std::uint32_t w : near) {
    if (w == second || fans.around(w) != Around::nothing) continue;
    const Face face{v, second, w};
    const double r = circumradius(places, face);
    if (!(r < radius) || !places.short_enough(v, w) || !places.short_enough(second, w)) continue;
    if (!ball_is_empty(places, face, near)) continue;
    best = face;
    radius = r;
  }
  if (!(radius < std::numeric_limits<double>::infinity())) return false;
  fans.add(facing_normals(places, best));
  return true;
}

bool all_on_a_line(std::span<const Point3> points) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  const auto exact = [](const Point3& p) { return Kernel::Point_3(p[0], p[1], p[2]); };
  return std::ranges::all_of(
      points, [&](const Point3& p) { return CGAL::collinear(exact(points[0]), exact(points[1]), exact(p)); });
}

}  // namespace surfaced::front
