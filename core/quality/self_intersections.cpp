// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/Box_intersection_d/Box_with_handle_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <span>

#include "quality/quality.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Box = CGAL::Box_intersection_d::Box_with_handle_d<double, 3, const Triangle*>;

/// Thrown through CGAL's box traversal to end it at the cap.
struct CapReached {};

/// Decides for two triangles of a mesh whether they meet elsewhere than in what they share.
class PairTest {
 public:
  explicit PairTest(const TriangleMesh& mesh) : mesh_(mesh) {}

  bool degenerate(const Triangle& t) const { return CGAL::collinear(point(t[0]), point(t[1]), point(t[2])); }

  bool intersect(const Triangle& s, const Triangle& t) const {
    std::vector<VertexIndex> shared;
    for (const VertexIndex v : s) {
      if (std::ranges::find(t, v) != t.end()) shared.push_back(v);
    }
    if (shared.size() == 3) return true;
    if (shared.size() == 2) return folded(s, t, shared);
    if (shared.size() == 1) return opposite_edge_meets(s, t, shared[0]) || opposite_edge_meets(t, s, shared[0]);
    return CGAL::do_intersect(triangle(s), triangle(t));
  }

 private:
  Kernel::Point_3 point(VertexIndex v) const {
    const Point3& p = mesh_.positions[v];
    return {p[0], p[1], p[2]};
  }
  Kernel::Triangle_3 triangle(const Triangle& t) const { return {point(t[0]), point(t[1]), point(t[2])}; }

  static VertexIndex other(const Triangle& t, const std::vector<VertexIndex>& shared) {
    return *std::ranges::find_if(t, [&](VertexIndex v) { return std::ranges::find(shared, v) == shared.end(); });
  }

  /// Two triangles over one edge meet elsewhere only if they are coplanar and on the same side of it.
  bool folded(const Triangle& s, const Triangle& t, const std::vector<VertexIndex>& shared) const {
    const auto a = point(shared[0]);
    const auto b = point(shared[1]);
    const auto p = point(other(s, shared));
    const auto q = point(other(t, shared));
    return CGAL::coplanar(a, b, p, q) && CGAL::coplanar_orientation(a, b, p, q) == CGAL::POSITIVE;
  }

  /// Whether the edge of `s` opposite the shared vertex meets `t`.
  bool opposite_edge_meets(const Triangle& s, const Triangle& t, VertexIndex shared) const {
    std::size_t i = 0;
    while (s[i] != shared) ++i;
    return CGAL::do_intersect(Kernel::Segment_3(point(s[(i + 1) % 3]), point(s[(i + 2) % 3])), triangle(t));
  }

  const TriangleMesh& mesh_;
};

/// Boxes of the triangles that have an area.
std::vector<Box> boxes_of(const TriangleMesh& mesh, const PairTest& test, std::span<const Triangle> triangles) {
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    if (test.degenerate(t)) continue;
    CGAL::Bbox_3 box;
    for (const VertexIndex v : t) {
      const Point3& p = mesh.positions[v];
      box += CGAL::Bbox_3(p[0], p[1], p[2], p[0], p[1], p[2]);
    }
    boxes.emplace_back(box, &t);
  }
  return boxes;
}

}  // namespace

std::size_t count_self_intersections(const TriangleMesh& mesh, std::size_t cap) {
  const PairTest test(mesh);
  std::vector<Box> boxes = boxes_of(mesh, test, mesh.triangles);
  std::size_t pairs = 0;
  try {
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
      if (test.intersect(*a.handle(), *b.handle()) && ++pairs >= cap) throw CapReached{};
    });
  } catch (const CapReached&) {
    return cap;
  }
  return pairs;
}

std::vector<std::array<std::uint32_t, 2>> intersections_from(const TriangleMesh& mesh, std::size_t first) {
  const PairTest test(mesh);
  std::vector<Box> all = boxes_of(mesh, test, mesh.triangles);
  std::vector<Box> fresh = boxes_of(mesh, test, std::span(mesh.triangles).subspan(first));
  const auto index = [&](const Box& box) { return static_cast<std::uint32_t>(box.handle() - mesh.triangles.data()); };
  std::vector<std::array<std::uint32_t, 2>> pairs;
  CGAL::box_intersection_d(fresh.begin(), fresh.end(), all.begin(), all.end(), [&](const Box& a, const Box& b) {
    if (a.handle() != b.handle() && test.intersect(*a.handle(), *b.handle())) pairs.push_back({index(a), index(b)});
  });
  return pairs;
}

}  // namespace surfaced
