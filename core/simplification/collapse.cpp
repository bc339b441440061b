// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: M. Garland, P. Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997; P. Lindstrom,
// G. Turk (1998) for the framework of collapses; both as implemented by CGAL's Surface_mesh_simplification.
#include "simplification/collapse.hpp"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Edge_collapse_visitor_base.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <algorithm>
#include <cmath>

#include "cloud/cloud.hpp"

namespace surfaced::simplification {
namespace {

namespace Sms = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Profile = Sms::Edge_profile<Mesh>;

constexpr std::size_t kStepsBetweenChecks = 1024;

/// Places around the least corner of the mesh, times a power of two that brings its size to [1, 2): quadrics of places
/// far from the origin lose all their digits.
class Frame {
 public:
  explicit Frame(const TriangleMesh& mesh) {
    const Bounds bounds = bounds_of(mesh.positions);
    low_ = bounds.low;
    int exponent = 0;
    std::frexp(std::ranges::max(bounds.high - bounds.low), &exponent);
    exponent_ = 1 - exponent;
  }

  Kernel::Point_3 into(const Point3& p) const {
    const Point3 q = p - low_;
    return {std::ldexp(q[0], exponent_), std::ldexp(q[1], exponent_), std::ldexp(q[2], exponent_)};
  }
  Point3 back(const Kernel::Point_3& p) const {
    return {std::ldexp(p.x(), -exponent_) + low_[0], std::ldexp(p.y(), -exponent_) + low_[1],
            std::ldexp(p.z(), -exponent_) + low_[2]};
  }
  double into(double length) const { return std::ldexp(length, exponent_); }

 private:
  Point3 low_{};
  int exponent_ = 0;
};

Mesh framed(const TriangleMesh& mesh, const Frame& frame) {
  Mesh result;
  result.reserve(static_cast<Mesh::size_type>(mesh.positions.size()),
                 static_cast<Mesh::size_type>(3 * mesh.triangles.size() / 2 + 1),
                 static_cast<Mesh::size_type>(mesh.triangles.size()));
  for (const Point3& p : mesh.positions) result.add_vertex(frame.into(p));
  std::vector<std::array<Mesh::Vertex_index, 3>> faces;
  faces.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    faces.push_back({Mesh::Vertex_index(t[0].value), Mesh::Vertex_index(t[1].value), Mesh::Vertex_index(t[2].value)});
  }
  CGAL::Euler::add_faces(faces, result);
  return result;
}

/// Ends the collapses at the goal or when the caller wants so.
struct ShouldStop {
  const Mesh* mesh;
  std::size_t triangles;
  double cost;
  Context* context;
  std::size_t first;
  mutable std::size_t calls = 0;

  bool operator()(double next_cost, const Profile&, std::size_t, std::size_t) const {
    const std::size_t left = mesh->number_of_faces();
    if (++calls % kStepsBetweenChecks == 0) {
      stop_if_cancelled(*context);
      const double done =
          static_cast<double>(first - left) / static_cast<double>(std::max<std::size_t>(1, first - triangles));
      context->report(kShareOfCollapses * (0.3 + 0.7 * done));
    }
    return left <= triangles || next_cost > cost;
  }
};

/// Remembers the vertices that collapses placed anew; looks at the caller's wish to stop while costs are collected.
struct Visitor : Sms::Edge_collapse_visitor_base<Mesh> {
  Visitor(std::vector<bool>& touched_vertices, Context& its_context)
      : touched(&touched_vertices), context(&its_context) {}

  /// @tparam Cost  an optional number: Boost's in CGAL 5, std's in CGAL 6
  template <class Cost>
  void OnCollected(const Profile&, const Cost&) {
    if (++collected % kStepsBetweenChecks == 0) stop_if_cancelled(*context);
  }
  void OnCollapsed(const Profile&, Mesh::Vertex_index kept) { (*touched)[kept] = true; }

  std::vector<bool>* touched;
  Context* context;
  std::size_t collected = 0;
};

Collapsed unframed(const Mesh& collapsed, const TriangleMesh& mesh, const std::vector<bool>& touched,
                   const Frame& frame) {
  Collapsed result;
  std::vector<VertexIndex> renumbered(mesh.positions.size());
  for (const Mesh::Vertex_index v : collapsed.vertices()) {
    renumbered[v] = VertexIndex(result.untouched.size());
    result.untouched.push_back(touched[v] ? VertexIndex() : VertexIndex(static_cast<std::size_t>(v)));
    result.mesh.positions.push_back(touched[v] ? frame.back(collapsed.point(v)) : mesh.positions[v]);
  }
  for (const Mesh::Face_index f : collapsed.faces()) {
    Triangle& t = result.mesh.triangles.emplace_back();
    std::size_t corner = 0;
    for (const Mesh::Vertex_index v : collapsed.vertices_around_face(collapsed.halfedge(f))) {
      t.at(corner++) = renumbered[v];
    }
  }
  return result;
}

}  // namespace

Collapsed collapse(const TriangleMesh& mesh, const Stop& stop, Context& context) {
  const Frame frame(mesh);
  Mesh work = framed(mesh, frame);
  const Sms::GarlandHeckbert_plane_policies<Mesh, Kernel> quadrics(work);
  const double error = frame.into(stop.error);
  const ShouldStop should_stop{&work, stop.triangles, error * error, &context, mesh.triangles.size()};
  std::vector<bool> touched(mesh.positions.size(), false);
  Visitor visitor(touched, context);
  Sms::edge_collapse(work, should_stop,
                     CGAL::parameters::get_cost(quadrics.get_cost())
                         .get_placement(quadrics.get_placement())
                         .filter(Sms::Bounded_normal_change_filter<>())
                         .visitor(visitor));
  return unframed(work, mesh, touched, frame);
}

}  // namespace surfaced::simplification
