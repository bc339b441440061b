// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "mesh/mesh.hpp"

namespace surfaced {
namespace {

/// Corner h of a triangle is where half-edge h starts.
std::size_t corner_at(const TriangleMesh& mesh, std::size_t triangle, VertexIndex v) {
  const Triangle& t = mesh.triangles[triangle];
  return 3 * triangle + (t[0] == v ? 0U : t[1] == v ? 1U : 2U);
}

/// Half-edges grouped by undirected edge: those of edge e are order[starts[e]] .. order[starts[e+1]-1].
struct EdgeGroups {
  std::vector<std::uint32_t> starts;
  std::vector<std::uint32_t> order;
};

EdgeGroups group_by_edge(const HalfEdges& half_edges, std::size_t count) {
  EdgeGroups groups{std::vector<std::uint32_t>(half_edges.edges() + 1, 0), std::vector<std::uint32_t>(count)};
  for (std::size_t e = 0; e < half_edges.edges(); ++e) {
    groups.starts[e + 1] = groups.starts[e] + static_cast<std::uint32_t>(half_edges.uses(e));
  }
  std::vector<std::uint32_t> cursor(groups.starts.begin(), groups.starts.end() - 1);
  for (std::size_t h = 0; h < count; ++h) {
    groups.order[cursor[half_edges.edge_of(HalfEdgeIndex(h))]++] = static_cast<std::uint32_t>(h);
  }
  return groups;
}

/// Joins the corners of neighbouring triangles: the sets left at a vertex are its fans and umbrellas.
UnionFind join_corners(const TriangleMesh& mesh, const EdgeGroups& groups) {
  UnionFind corners(3 * mesh.triangles.size());
  for (std::size_t e = 0; e + 1 < groups.starts.size(); ++e) {
    const std::size_t first = groups.order[groups.starts[e]];
    const VertexIndex a = mesh.triangles[first / 3][first % 3];
    const VertexIndex b = mesh.triangles[first / 3][(first % 3 + 1) % 3];
    for (std::size_t i = groups.starts[e] + 1; i < groups.starts[e + 1]; ++i) {
      const std::size_t triangle = groups.order[i] / 3;
      corners.unite(corner_at(mesh, first / 3, a), corner_at(mesh, triangle, a));
      corners.unite(corner_at(mesh, first / 3, b), corner_at(mesh, triangle, b));
    }
  }
  return corners;
}

void judge_edges(const HalfEdges& half_edges, const TriangleMesh& mesh, const EdgeGroups& groups, Topology& topology) {
  topology.edges = half_edges.edges();
  topology.oriented = true;
  for (std::size_t e = 0; e < half_edges.edges(); ++e) {
    const std::size_t uses = half_edges.uses(e);
    topology.boundary_edges += uses == 1 ? 1 : 0;
    topology.non_manifold_edges += uses > 2 ? 1 : 0;
    std::size_t forward = 0;
    const std::size_t first = groups.order[groups.starts[e]];
    const VertexIndex tail = mesh.triangles[first / 3][first % 3];
    for (std::size_t i = groups.starts[e]; i < groups.starts[e + 1]; ++i) {
      const std::size_t h = groups.order[i];
      if (mesh.triangles[h / 3][h % 3] == tail) ++forward;
    }
    if (forward > 1 || uses - forward > 1) topology.oriented = false;
  }
  topology.edge_manifold = topology.non_manifold_edges == 0;
  topology.closed = topology.triangles > 0 && topology.boundary_edges == 0 && topology.edge_manifold;
}

void judge_vertices(const TriangleMesh& mesh, UnionFind& corners, Topology& topology) {
  std::vector<std::uint32_t> fans(mesh.positions.size(), 0);
  std::vector<bool> used(mesh.positions.size(), false);
  for (std::size_t h = 0; h < corners.size(); ++h) {
    const VertexIndex v = mesh.triangles[h / 3][h % 3];
    used[v] = true;
    if (corners.find(h) == h) ++fans[v];
  }
  topology.vertices = static_cast<std::size_t>(std::ranges::count(used, true));
  topology.non_manifold_vertices = static_cast<std::size_t>(std::ranges::count_if(fans, [](auto n) { return n > 1; }));
  topology.vertex_manifold = topology.non_manifold_vertices == 0 && topology.edge_manifold;
}

/// Boundary half-edges whose ends lie in the same fan follow one another.
std::size_t count_boundary_loops(const HalfEdges& half_edges, UnionFind& corners) {
  std::vector<std::uint32_t> boundary;
  for (std::size_t h = 0; h < corners.size(); ++h) {
    if (half_edges.uses(half_edges.edge_of(HalfEdgeIndex(h))) == 1) boundary.push_back(static_cast<std::uint32_t>(h));
  }
  UnionFind loops(boundary.size());
  std::vector<std::uint32_t> at_fan(corners.size(), VertexIndex::kNone);
  std::size_t joins = 0;
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    for (const std::size_t corner :
         {std::size_t{boundary[i]}, std::size_t{HalfEdges::next(HalfEdgeIndex(boundary[i]))}}) {
      std::uint32_t& other = at_fan[corners.find(corner)];
      if (other == VertexIndex::kNone) {
        other = static_cast<std::uint32_t>(i);
      } else if (loops.unite(other, i)) {
        ++joins;
      }
    }
  }
  return boundary.size() - joins;
}

/// Union-find over vertices: the parts connected through shared vertices.
UnionFind connect_vertices(const TriangleMesh& mesh) {
  UnionFind parts(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    parts.unite(t[0], t[1]);
    parts.unite(t[0], t[2]);
  }
  return parts;
}

double triangle_volume(const TriangleMesh& mesh, const Triangle& t, const Point3& origin) {
  const Point3 a = mesh.positions[t[0]] - origin;
  const Point3 b = mesh.positions[t[1]] - origin;
  const Point3 c = mesh.positions[t[2]] - origin;
  return dot(a, cross(b, c)) / 6;
}

/// A component, and what tells which of its sides is the outer one.
struct Part {
  Point3 centre{};
  std::size_t triangles = 0;
  double volume = 0;
  bool oriented = true;
};

/// The components with the mean of their triangles' corners.
std::vector<Part> centred_parts(const TriangleMesh& mesh, const Components& components) {
  std::vector<Part> parts(components.count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Part& part = parts[components.of_triangle[t]];
    ++part.triangles;
    for (const VertexIndex v : mesh.triangles[t]) {
      for (std::size_t axis = 0; axis < 3; ++axis) part.centre[axis] += mesh.positions[v][axis];
    }
  }
  for (Part& part : parts) {
    for (double& x : part.centre) x /= 3 * static_cast<double>(part.triangles);
  }
  return parts;
}

void turn_outwards(TriangleMesh& mesh, const Components& components, std::vector<Part>& parts) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Part& part = parts[components.of_triangle[t]];
    part.volume += triangle_volume(mesh, mesh.triangles[t], part.centre);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Part& part = parts[components.of_triangle[t]];
    if (part.oriented && part.volume < 0) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  }
}

}  // namespace

Topology topology_of(const TriangleMesh& mesh) {
  Topology topology;
  topology.triangles = mesh.triangles.size();
  const HalfEdges half_edges(mesh.triangles, mesh.positions.size());
  const EdgeGroups groups = group_by_edge(half_edges, 3 * mesh.triangles.size());
  UnionFind corners = join_corners(mesh, groups);
  judge_edges(half_edges, mesh, groups, topology);
  judge_vertices(mesh, corners, topology);
  topology.boundary_loops = count_boundary_loops(half_edges, corners);
  topology.components = components_of(mesh).count;
  topology.euler_characteristic = static_cast<std::int64_t>(topology.vertices) -
                                  static_cast<std::int64_t>(topology.edges) +
                                  static_cast<std::int64_t>(topology.triangles);
  if (topology.triangles > 0 && topology.vertex_manifold && topology.oriented) {
    topology.genus = static_cast<std::int64_t>(topology.components) -
                     (topology.euler_characteristic + static_cast<std::int64_t>(topology.boundary_loops)) / 2;
  }
  return topology;
}

Components components_of(const TriangleMesh& mesh) {
  UnionFind parts = connect_vertices(mesh);
  Components components{std::vector<std::uint32_t>(mesh.triangles.size()), 0};
  std::vector<std::uint32_t> number(mesh.positions.size(), VertexIndex::kNone);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::uint32_t& id = number[parts.find(mesh.triangles[t][0])];
    if (id == VertexIndex::kNone) id = static_cast<std::uint32_t>(components.count++);
    components.of_triangle[t] = id;
  }
  return components;
}

UnionFind fans_of_corners(const TriangleMesh& mesh) {
  const HalfEdges half_edges(mesh.triangles, mesh.positions.size());
  UnionFind fans(3 * mesh.triangles.size());
  for (std::size_t h = 0; h < fans.size(); ++h) {
    const HalfEdgeIndex mate = half_edges.mate(HalfEdgeIndex(h));
    if (mate.valid()) fans.unite(h, HalfEdges::next(mate));
  }
  return fans;
}

double signed_volume(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return 0;
  const Point3 origin = mesh.positions[mesh.triangles.front()[0]];
  double volume = 0;
  for (const Triangle& t : mesh.triangles) volume += triangle_volume(mesh, t, origin);
  return volume;
}

void orient_outwards(TriangleMesh& mesh) {
  const Components components = components_of(mesh);
  std::vector<Part> parts = centred_parts(mesh, components);
  const HalfEdges half_edges(mesh.triangles, mesh.positions.size());
  for (std::size_t h = 0; h < 3 * mesh.triangles.size(); ++h) {
    const bool boundary = half_edges.uses(half_edges.edge_of(HalfEdgeIndex(h))) == 1;
    parts[components.of_triangle[h / 3]].oriented &= boundary || half_edges.mate(HalfEdgeIndex(h)).valid();
  }
  turn_outwards(mesh, components, parts);
}

void orient_oriented_outwards(TriangleMesh& mesh) {
  const Components components = components_of(mesh);
  std::vector<Part> parts = centred_parts(mesh, components);
  turn_outwards(mesh, components, parts);
}

void sort_triangles(TriangleMesh& mesh) {
  for (Triangle& t : mesh.triangles) std::rotate(t.begin(), std::ranges::min_element(t), t.end());
  if (!std::ranges::is_sorted(mesh.triangles)) std::ranges::sort(mesh.triangles);
}

}  // namespace surfaced
