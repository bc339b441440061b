// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "base/vectors.hpp"
#include "quality/quality.hpp"
#include "quality/triangle_tree.hpp"

namespace surfaced {
namespace {

using quality::Kernel;
using quality::point;
using quality::Tree;
using quality::Triangles;

/// Fractional part of i times an irrational number: evenly spread, the same in every run.
double spread(std::size_t i, double step) {
  const double x = static_cast<double>(i) * step;
  return x - std::floor(x);
}

/// The place of sample i within a triangle, evenly by area.
Point3 place_in(const TriangleMesh& mesh, const Triangle& t, std::size_t i) {
  double u = spread(i + 1, 0.7548776662466927);  // of the plastic number: R2 (M. Roberts, 2018)
  double v = spread(i + 1, 0.5698402909980532);
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  const Point3& a = mesh.positions[t[0]];
  return a + (u * (mesh.positions[t[1]] - a) + v * (mesh.positions[t[2]] - a));
}

/// What a ray hits, if it is of this kind: CGAL 5 says it by Boost's variant, CGAL 6 by std's.
template <class Kind, class Variant>
const Kind* hit_as(const Variant& hit) {
  if constexpr (requires { hit.which(); }) {
    return boost::get<Kind>(&hit);
  } else {
    return std::get_if<Kind>(&hit);
  }
}

/// How far it is through the body to the next wall; none if the ray meets nothing.
std::optional<double> depth_at(const Tree& tree, const Triangles& triangles, std::size_t triangle, const Point3& place,
                               const Point3& inwards) {
  const auto own = triangles.cbegin() + static_cast<std::ptrdiff_t>(triangle);
  const Kernel::Ray_3 ray(point(place), Kernel::Vector_3(inwards[0], inwards[1], inwards[2]));
  const auto hit = tree.first_intersection(ray, [&](Triangles::const_iterator t) { return t == own; });
  if (!hit) return std::nullopt;
  if (const auto* at = hit_as<Kernel::Point_3>(hit->first)) {
    return std::sqrt(CGAL::squared_distance(*at, ray.source()));
  }
  const auto* along = hit_as<Kernel::Segment_3>(hit->first);
  return std::sqrt(CGAL::squared_distance(*along, ray.source()));
}

}  // namespace

std::vector<double> wall_thicknesses(const TriangleMesh& mesh, std::size_t samples) {
  std::vector<double> areas_until;
  std::vector<TriangleIndex> number;
  Triangles triangles;
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto corner = [&](std::size_t k) -> const Point3& { return mesh.positions[mesh.triangles[t][k]]; };
    const Kernel::Triangle_3 triangle(point(corner(0)), point(corner(1)), point(corner(2)));
    if (triangle.is_degenerate()) continue;
    area += shape_of(corner(0), corner(1), corner(2)).area;
    areas_until.push_back(area);
    number.emplace_back(t);
    triangles.push_back(triangle);
  }
  std::vector<double> depths;
  if (!(area > 0)) return depths;
  const Tree tree(triangles.cbegin(), triangles.cend());
  for (std::size_t i = 0; i < samples; ++i) {
    const double at = area * (static_cast<double>(i) + 0.5) / static_cast<double>(samples);
    const auto chosen = static_cast<std::size_t>(std::ranges::upper_bound(areas_until, at) - areas_until.begin());
    if (chosen == triangles.size()) continue;
    const Triangle& t = mesh.triangles[number[chosen]];
    const Point3& a = mesh.positions[t[0]];
    const auto inwards = direction_of(cross(mesh.positions[t[2]] - a, mesh.positions[t[1]] - a));
    if (!inwards) continue;
    const auto depth = depth_at(tree, triangles, chosen, place_in(mesh, t, i), *inwards);
    if (depth) depths.push_back(*depth);
  }
  std::ranges::sort(depths);
  return depths;
}

}  // namespace surfaced
