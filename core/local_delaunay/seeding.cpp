// SPDX-License-Identifier: GPL-3.0-or-later
#include "local_delaunay/seeding.hpp"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>

namespace surfaced::ldt {

using front::Face;
using front::Fans;
using front::Places;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using Delaunay2 = CGAL::Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<VertexBase, CGAL::Triangulation_face_base_2<Kernel>>>;

}  // namespace

bool seed_local_triangulation(Fans& fans, Places& places, std::uint32_t v, std::size_t n) {
  if (front::surface_is_near(fans, places, v)) return false;
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

}  // namespace surfaced::ldt
