// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes with holes cut into them, and slow plain checks of what was put there.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mesh/mesh.hpp"
#include "support/shapes.hpp"

namespace surfaced::testing {

/// A sphere with bumps on it: an icosphere, every triangle cut in four `level` times.
inline TriangleMesh bumpy_sphere(int level, double bump = 0.05) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  TriangleMesh mesh;
  mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  constexpr std::array<std::array<std::size_t, 3>, 20> kFaces{
      {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
       {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
       {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  for (const auto& f : kFaces) mesh.triangles.push_back(triangle(f[0], f[1], f[2]));
  for (int i = 0; i < level; ++i) {
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> middles;
    std::vector<Triangle> finer;
    const auto middle = [&](VertexIndex a, VertexIndex b) {
      const auto [at, is_new] = middles.emplace(std::minmax<std::size_t>(a, b), mesh.positions.size());
      if (is_new) {
        const Point3 p = mesh.positions[a];
        const Point3 q = mesh.positions[b];
        mesh.positions.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2});
      }
      return at->second;
    };
    for (const Triangle& t : mesh.triangles) {
      const std::size_t ab = middle(t[0], t[1]);
      const std::size_t bc = middle(t[1], t[2]);
      const std::size_t ca = middle(t[2], t[0]);
      for (const auto& f :
           {triangle(t[0], ab, ca), triangle(ab, t[1], bc), triangle(ca, bc, t[2]), triangle(ab, bc, ca)}) {
        finer.push_back(f);
      }
    }
    mesh.triangles = std::move(finer);
  }
  for (Point3& p : mesh.positions) {
    const double length = norm(p);
    for (double& x : p) x /= length;
    const double r = 1 + bump * std::sin(4 * p[0]) * std::sin(4 * p[1] + 1) * std::sin(4 * p[2] + 2);
    for (double& x : p) x *= r;
  }
  return mesh;
}

/// The mesh without the triangles around the vertex nearest to the centre that have a vertex within `radius` of the
/// centre and hang together, and those triangles alone; vertex numbers stay.
struct Cut {
  TriangleMesh rest;
  TriangleMesh removed;
};
inline Cut cut_disc(const TriangleMesh& mesh, const Point3& centre, double radius) {
  Cut cut{mesh, mesh};
  cut.rest.triangles.clear();
  cut.removed.triangles.clear();
  const auto distance = [&](VertexIndex v) { return norm(mesh.positions[v] - centre); };
  TriangleMesh within = cut.removed;
  for (const Triangle& t : mesh.triangles) {
    const bool inside = std::ranges::any_of(t, [&](VertexIndex v) { return distance(v) < radius; });
    (inside ? within : cut.rest).triangles.push_back(t);
  }
  const Components parts = components_of(within);
  std::pair<double, std::uint32_t> nearest{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t t = 0; t < within.triangles.size(); ++t) {
    for (const VertexIndex v : within.triangles[t]) {
      nearest = std::min(nearest, {distance(v), parts.of_triangle[t]});
    }
  }
  for (std::size_t t = 0; t < within.triangles.size(); ++t) {
    (parts.of_triangle[t] == nearest.second ? cut.removed : cut.rest).triangles.push_back(within.triangles[t]);
  }
  return cut;
}

/// Distance from p to the triangle abc, by the regions of the triangle (Ericson, Real-Time Collision Detection, 5.1.5).
inline double distance_to_triangle(const Point3& p, const Point3& a, const Point3& b, const Point3& c) {
  const auto along = [](const Point3& o, const Point3& d, double s) {
    return Point3{o[0] + s * d[0], o[1] + s * d[1], o[2] + s * d[2]};
  };
  const Point3 ab = b - a;
  const Point3 ac = c - a;
  const double d1 = dot(ab, p - a);
  const double d2 = dot(ac, p - a);
  if (d1 <= 0 && d2 <= 0) return norm(p - a);
  const double d3 = dot(ab, p - b);
  const double d4 = dot(ac, p - b);
  if (d3 >= 0 && d4 <= d3) return norm(p - b);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return norm(p - along(a, ab, d1 / (d1 - d3)));
  const double d5 = dot(ab, p - c);
  const double d6 = dot(ac, p - c);
  if (d6 >= 0 && d5 <= d6) return norm(p - c);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return norm(p - along(a, ac, d2 / (d2 - d6)));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return norm(p - along(b, c - b, (d4 - d3) / (d4 - d3 + d5 - d6)));
  const double sum = va + vb + vc;
  return norm(p - along(along(a, ab, vb / sum), ac, vc / sum));
}

inline double distance_to_mesh(const Point3& p, const TriangleMesh& mesh) {
  double least = std::numeric_limits<double>::infinity();
  for (const Triangle& t : mesh.triangles) {
    least = std::min(least, distance_to_triangle(p, mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]));
  }
  return least;
}

/// Mean distance, weighted by area, of the centres of new triangles of a mesh to the surface that it was made of, near
/// a place.
/// @param rest  what was left of the surface: triangles of the mesh that it has are not new.
inline double mean_distance(const TriangleMesh& mesh, const TriangleMesh& rest, const TriangleMesh& surface,
                            const Point3& place, double radius) {
  const auto within = [&](const Triangle& t, const TriangleMesh& of, double reach) {
    return std::ranges::all_of(t, [&](VertexIndex v) { return norm(of.positions[v] - place) < reach; });
  };
  TriangleMesh around{.positions = surface.positions, .triangles = {}, .normals = {}, .colors = {}};
  for (const Triangle& t : surface.triangles) {
    if (within(t, surface, 2 * radius)) around.triangles.push_back(t);
  }
  const std::set<Triangle> old(rest.triangles.begin(), rest.triangles.end());
  double sum = 0;
  double area = 0;
  for (const Triangle& t : mesh.triangles) {
    if (old.contains(t) || !within(t, mesh, 1.5 * radius)) continue;
    const Point3& a = mesh.positions[t[0]];
    const Point3& b = mesh.positions[t[1]];
    const Point3& c = mesh.positions[t[2]];
    const double weight = norm(cross(b - a, c - a)) / 2;
    const Point3 centre{(a[0] + b[0] + c[0]) / 3, (a[1] + b[1] + c[1]) / 3, (a[2] + b[2] + c[2]) / 3};
    sum += weight * distance_to_mesh(centre, around);
    area += weight;
  }
  return sum / area;
}

/// What keeps a mesh, open or closed, from being an oriented manifold, by maps; empty if nothing does.
inline std::string manifold_problem(const TriangleMesh& mesh) {
  std::set<std::pair<std::size_t, std::size_t>> directed;
  std::map<std::size_t, std::map<std::size_t, std::size_t>> links;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (!directed.emplace(t[i], t[(i + 1) % 3]).second) return "a directed edge is used twice";
      links[t[i]][t[(i + 1) % 3]] = t[(i + 2) % 3];
    }
  }
  for (const auto& [vertex, next] : links) {
    std::set<std::size_t> heads;
    for (const auto& [from, to] : next) heads.insert(to);
    std::vector<std::size_t> starts;
    for (const auto& [from, to] : next) {
      if (!heads.contains(from)) starts.push_back(from);
    }
    if (starts.size() > 1) return "vertex " + std::to_string(vertex) + " has several fans";
    std::size_t at = starts.empty() ? next.begin()->first : starts.front();
    std::size_t steps = 0;
    for (auto found = next.find(at); found != next.end() && steps <= next.size(); found = next.find(at)) {
      at = found->second;
      if (++steps == next.size()) break;
    }
    if (steps != next.size()) return "vertex " + std::to_string(vertex) + " has more than one fan or umbrella";
    if (next.size() < 3 && starts.empty()) return "vertex " + std::to_string(vertex) + " has two faces back to back";
  }
  return {};
}

}  // namespace surfaced::testing
