#include "local_delaunay/seeding.hpp"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace surfaced::ldt {

using front::Around;
using front::Face;
using front::Fans;
using front::Places;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using Delaunay2 = CGAL::Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<VertexBase, CGAL::Triangulation_face_base_2<Kernel>>>;

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

double circumradius(const Places& places, const Face& f) {
  const Point3 a = places.position(f[0]);
  const Point3 b = places.position(f[1]);
  const Point3 c = places.position(f[2]);
  const double area = norm(cross(b - a, c - a));
  if (!(area > 0)) return std::numeric_limits<double>::infinity();
  return norm(b - a) * norm(c - b) * norm(a - c) / (2 * area);
}

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
  const Point3 n = front::area_normal(places, f);
  double agreement = 0;
  for (const std::uint32_t v : f) agreement += dot(n, places.normal(v));
  if (agreement < 0) std::swap(f[1], f[2]);
  return f;
}

}  // namespace

bool seed_triangle(Fans& fans, Places& places, std::uint32_t v) {
  if (surface_is_near(fans, places, v)) return false;
  const auto list = places.neighbours(v);
  std::vector<std::uint32_t> near(list.begin(), list.end());
  std::uint32_t second = front::kNoVertex;
  double least = std::numeric_limits<double>::infinity();
  for (const std::uint32_t w : near) {
    const double distance = norm(places.position(w) - places.position(v));
    if (fans.around(w) != Around::nothing || !(distance < least)) continue;
    least = distance;
    second = w;
  }
  if (second == front::kNoVertex || !places.short_enough(v, second)) return false;
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

bool seed_local_triangulation(Fans& fans, Places& places, std::uint32_t v, std::size_t n) {
  if (surface_is_near(fans, places, v)) return false;
  const auto list = places.neighbours(v);
  std::vector<std::uint32_t> near(list.begin(), list.end());
  const Point3 origin = places.position(v);
  std::ranges::sort(near, {}, [&](std::uint32_t w) { return std::pair(norm(places.position(w) - origin), w); });
  near.resize(std::min(near.size(), n));
  near.push_back(v);
  const Point3 normal = places.normal(v);
  const Point3 first = places.position(near.front()) - origin;
  const Point3 y = cross(normal, first);
  const Point3 x = cross(y, normal);
  Delaunay2 plane;
  for (const std::uint32_t w : near) {
    const Point3 d = places.position(w) - origin;
    plane.insert(Kernel::Point_2(dot(d, x), dot(d, y)))->info() = w;
  }
  bool any = false;
  for (auto f = plane.finite_faces_begin(); f != plane.finite_faces_end(); ++f) {
    const Face face{f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()};
    constexpr double kLeastCosine = 0;
    if (!front::legal(fans, places, face, kLeastCosine)) continue;
    fans.add(face);
    any = true;
  }
  return any;
}

bool all_on_a_line(std::span<const Point3> points) {
  const auto exact = [](const Point3& p) { return Kernel::Point_3(p[0], p[1], p[2]); };
  return std::ranges::all_of(
      points, [&](const Point3& p) { return CGAL::collinear(exact(points[0]), exact(points[1]), exact(p)); });
}

}  // namespace surfaced::ldt
