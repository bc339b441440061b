// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/Random.h>

#include "quality/quality.hpp"
#include "quality/triangle_tree.hpp"

namespace surfaced {
namespace {

using quality::Kernel;
using quality::point;
using quality::Tree;
using quality::Triangles;

/// How a segment from a query point to a point outside the mesh's bounds meets the mesh.
enum class Crossing : std::uint8_t { inside, outside, on_surface, ambiguous };

/// True if the segment meets the triangle in one point of its interior.
bool crosses_interior(const Kernel::Segment_3& s, const Kernel::Triangle_3& t) {
  const auto side = [&](int i, int j) { return CGAL::orientation(s.source(), s.target(), t.vertex(i), t.vertex(j)); };
  const CGAL::Orientation first = side(0, 1);
  return first != CGAL::COPLANAR && side(1, 2) == first && side(2, 0) == first;
}

Crossing cast_ray(const Tree& tree, const Kernel::Segment_3& ray) {
  std::vector<Tree::Primitive_id> hit;
  tree.all_intersected_primitives(ray, std::back_inserter(hit));
  for (const auto& id : hit) {
    if (CGAL::do_intersect(ray.source(), *id)) return Crossing::on_surface;
  }
  for (const auto& id : hit) {
    if (id->is_degenerate() || !crosses_interior(ray, *id)) return Crossing::ambiguous;
  }
  return hit.size() % 2 == 1 ? Crossing::inside : Crossing::outside;
}

/// A mesh of which every ray meets an edge or a triangle without area has no inside to speak of.
constexpr int kMostRays = 200;

bool is_inside(const Tree& tree, const Kernel::Point_3& query) {
  const CGAL::Bbox_3 box = tree.bbox();
  const bool beyond = query.x() < box.xmin() || query.x() > box.xmax() || query.y() < box.ymin() ||
                      query.y() > box.ymax() || query.z() < box.zmin() || query.z() > box.zmax();
  if (beyond) return false;
  // A fixed seed: the answer does not depend on the directions, only whether one more is needed.
  CGAL::Random random(1);
  double reach = 4 * ((box.xmax() - box.xmin()) + (box.ymax() - box.ymin()) + (box.zmax() - box.zmin()));
  for (int ray = 0; ray < kMostRays; ++ray) {
    const Kernel::Vector_3 direction(random.get_double(-1, 1), random.get_double(-1, 1), random.get_double(-1, 1));
    if (direction.squared_length() < 0.25) continue;
    const Crossing crossing = cast_ray(tree, {query, query + direction * reach});
    if (crossing != Crossing::ambiguous) return crossing == Crossing::inside;
    // The ends of rays lie on the grid of what a double can hold: further off they have more directions.
    reach *= 2;
  }
  return false;
}

}  // namespace

std::size_t count_points_inside(const TriangleMesh& mesh, std::span<const Point3> points) {
  if (points.empty() || mesh.triangles.empty()) return 0;
  Triangles triangles;
  triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    triangles.emplace_back(point(mesh.positions[t[0]]), point(mesh.positions[t[1]]), point(mesh.positions[t[2]]));
  }
  const Tree tree(triangles.cbegin(), triangles.cend());
  std::size_t inside = 0;
  for (const Point3& p : points) inside += is_inside(tree, point(p)) ? 1U : 0U;
  return inside;
}

}  // namespace surfaced
