// SPDX-License-Identifier: GPL-3.0-or-later
// Source: P. Liepa, "Filling holes in meshes", SGP 2003, as CGAL has it.
#include "hole_filling/library_patch.hpp"

// Not asked for below, and a quarter of what compiling this would cost.
#define CGAL_HOLE_FILLING_DO_NOT_USE_CDT2
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/refine.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <exception>
#include <map>
#include <tuple>

namespace surfaced::filling {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace Pmp = CGAL::Polygon_mesh_processing;

std::vector<Kernel::Point_3> library_points(const std::vector<Point3>& points) {
  std::vector<Kernel::Point_3> result;
  result.reserve(points.size());
  for (const Point3& p : points) result.emplace_back(p[0], p[1], p[2]);
  return result;
}

/// A triangulation of the corners alone, as a mesh of its own: a disc, whatever the points are.
std::optional<SurfaceMesh> triangulate(const Hole& hole) {
  std::vector<std::tuple<int, int, int>> triangles;
  Pmp::triangulate_hole_polyline(library_points(hole.corners), library_points(hole.beyond),
                                 std::back_inserter(triangles));
  if (triangles.size() + 2 != hole.corners.size()) return std::nullopt;
  SurfaceMesh mesh;
  for (const Kernel::Point_3& p : library_points(hole.corners)) mesh.add_vertex(p);
  for (const auto& [a, b, c] : triangles) {
    const auto vertex = [](int i) { return SurfaceMesh::Vertex_index(static_cast<std::uint32_t>(i)); };
    if (mesh.add_face(vertex(a), vertex(b), vertex(c)) == SurfaceMesh::null_face()) return std::nullopt;
  }
  return mesh;
}

Patch patch_of(const SurfaceMesh& mesh) {
  Patch patch;
  for (const auto v : mesh.vertices()) {
    const Kernel::Point_3& p = mesh.point(v);
    patch.points.push_back({p.x(), p.y(), p.z()});
  }
  for (const auto f : mesh.faces()) {
    Corners t{};
    std::size_t i = 0;
    for (const auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh)) t[i++] = v.idx();
    patch.triangles.push_back(t);
  }
  return patch;
}

/// The library keeps the direction of the polyline or turns it, as its version likes.
void orient(Patch& patch, std::size_t corners) {
  for (const Corners& t : patch.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i];
      const std::uint32_t b = t[(i + 1) % 3];
      if (a >= corners || b != (a + corners - 1) % corners || (a + 1) % corners == b) continue;
      for (Corners& each : patch.triangles) std::swap(each[1], each[2]);
      return;
    }
  }
}

/// Splits the edges between corners that the mesh joins already.
void split_joined(Patch& patch, const Hole& hole) {
  const auto corners = static_cast<std::uint32_t>(hole.corners.size());
  const auto forbidden = [&](std::uint32_t a, std::uint32_t b) {
    const bool on_rim = (a + 1) % corners == b || (b + 1) % corners == a;
    return a < corners && b < corners && !on_rim && hole.joined(a, b);
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  for (std::size_t t = 0; t < patch.triangles.size();) {
    const Corners c = patch.triangles[t];
    std::size_t i = 0;
    while (i < 3 && !forbidden(c[i], c[(i + 1) % 3])) ++i;
    if (i == 3) {
      ++t;
      continue;
    }
    const std::uint32_t a = c[i];
    const std::uint32_t b = c[(i + 1) % 3];
    const auto [middle, is_new] = middles.emplace(std::minmax(a, b), static_cast<std::uint32_t>(patch.points.size()));
    if (is_new) {
      Point3 p{};
      for (std::size_t k = 0; k < 3; ++k) p[k] = (patch.points[a][k] + patch.points[b][k]) / 2;
      patch.points.push_back(p);
    }
    patch.triangles[t] = {a, middle->second, c[(i + 2) % 3]};
    patch.triangles.push_back({middle->second, b, c[(i + 2) % 3]});
  }
}

}  // namespace

std::optional<Patch> cover_by_library(const Hole& hole) {
  try {
    std::optional<SurfaceMesh> mesh = triangulate(hole);
    if (!mesh) return std::nullopt;
    std::vector<SurfaceMesh::Face_index> new_faces;
    std::vector<SurfaceMesh::Vertex_index> new_vertices;
    const std::vector<SurfaceMesh::Face_index> faces(mesh->faces().begin(), mesh->faces().end());
    Pmp::refine(*mesh, faces, std::back_inserter(new_faces), std::back_inserter(new_vertices));
    Patch patch = patch_of(*mesh);
    orient(patch, hole.corners.size());
    split_joined(patch, hole);
    return patch;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    return std::nullopt;  // the caller tries no further and names the loop
  }
}

}  // namespace surfaced::filling
