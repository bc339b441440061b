// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "support/shapes.hpp"

namespace surfaced {
namespace {

using testing::triangle;

TEST(Topology, tetrahedron_is_a_closed_oriented_sphere) {
  const Topology t = topology_of(testing::tetrahedron());
  EXPECT_TRUE(t.closed && t.edge_manifold && t.vertex_manifold && t.oriented);
  EXPECT_EQ(t.components, 1U);
  EXPECT_EQ(t.euler_characteristic, 2);
  EXPECT_EQ(t.genus, 0);
  EXPECT_EQ(t.boundary_loops, 0U);
  EXPECT_GT(signed_volume(testing::tetrahedron()), 0);
}

TEST(Topology, torus_has_genus_1_and_two_tori_have_2) {
  const TriangleMesh torus = testing::torus_mesh(12, 7);
  EXPECT_EQ(topology_of(torus).genus, 1);
  const Topology two = topology_of(testing::together(torus, torus, {5, 0, 0}));
  EXPECT_EQ(two.components, 2U);
  EXPECT_EQ(two.genus, 2);
  EXPECT_TRUE(two.closed);
}

TEST(Topology, one_missing_triangle_is_one_boundary_loop_and_leaves_the_genus) {
  TriangleMesh torus = testing::torus_mesh(12, 7);
  torus.triangles.erase(torus.triangles.begin() + 20);
  const Topology t = topology_of(torus);
  EXPECT_FALSE(t.closed);
  EXPECT_EQ(t.boundary_loops, 1U);
  EXPECT_EQ(t.boundary_edges, 3U);
  EXPECT_EQ(t.genus, 1);
}

TEST(Topology, one_turned_triangle_makes_it_unoriented_but_still_closed) {
  TriangleMesh mesh = testing::tetrahedron();
  std::swap(mesh.triangles[1][0], mesh.triangles[1][1]);
  const Topology t = topology_of(mesh);
  EXPECT_TRUE(t.closed);
  EXPECT_FALSE(t.oriented);
  EXPECT_FALSE(t.genus);
}

TEST(Topology, two_tetrahedra_that_touch_in_a_vertex_are_not_vertex_manifold) {
  TriangleMesh mesh = testing::tetrahedron();
  mesh.positions.insert(mesh.positions.end(), {{3, 1, 1}, {3, 3, 1}, {3, 1, 3}});
  for (const Triangle& t : {triangle(0, 5, 4), triangle(0, 4, 6), triangle(0, 6, 5), triangle(4, 5, 6)}) {
    mesh.triangles.push_back(t);
  }
  const Topology t = topology_of(mesh);
  EXPECT_TRUE(t.closed && t.edge_manifold && t.oriented);
  EXPECT_FALSE(t.vertex_manifold);
  EXPECT_EQ(t.non_manifold_vertices, 1U);
  EXPECT_EQ(t.components, 1U);
}

TEST(Topology, three_triangles_at_an_edge_are_not_edge_manifold) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
  mesh.triangles = {triangle(0, 1, 2), triangle(1, 0, 3), triangle(0, 1, 4)};
  const Topology t = topology_of(mesh);
  EXPECT_FALSE(t.edge_manifold);
  EXPECT_FALSE(t.oriented);
  EXPECT_EQ(t.non_manifold_edges, 1U);
}

TEST(Topology, two_loops_that_touch_in_a_vertex_are_counted_apart) {
  // A bow tie: two triangles that share only a vertex.
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  mesh.triangles = {triangle(0, 1, 2), triangle(0, 3, 4)};
  EXPECT_EQ(topology_of(mesh).boundary_loops, 2U);
}

TEST(Topology, an_empty_mesh_is_not_closed) {
  const Topology t = topology_of({});
  EXPECT_FALSE(t.closed);
  EXPECT_EQ(t.components, 0U);
  EXPECT_FALSE(t.genus);
}

TEST(Topology, vertices_of_no_triangle_do_not_count) {
  TriangleMesh mesh = testing::tetrahedron();
  mesh.positions.push_back({9, 9, 9});
  EXPECT_EQ(topology_of(mesh).vertices, 4U);
  EXPECT_EQ(topology_of(mesh).euler_characteristic, 2);
}

/// Counts by sets and maps, sharing nothing with the code under test.
struct Counted {
  std::size_t edges = 0;
  bool closed = true;
  bool edge_manifold = true;
  bool oriented = true;
  std::size_t pinched_vertices = 0;
};

/// Number of groups of triangles around v that are connected through edges at v.
std::size_t fans_at(const std::vector<Triangle>& triangles, VertexIndex v) {
  std::vector<std::set<std::uint32_t>> fans;
  for (const Triangle& t : triangles) {
    if (t[0] != v && t[1] != v && t[2] != v) continue;
    std::set<std::uint32_t> fan;
    for (const VertexIndex w : t) {
      if (w != v) fan.insert(w.value);
    }
    for (auto it = fans.begin(); it != fans.end();) {
      const bool meets = std::ranges::any_of(*it, [&](std::uint32_t w) { return fan.contains(w); });
      if (meets) fan.insert(it->begin(), it->end());
      it = meets ? fans.erase(it) : it + 1;
    }
    fans.push_back(fan);
  }
  return fans.size();
}

Counted counted(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> directed;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> undirected;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i].value;
      const std::uint32_t b = t[(i + 1) % 3].value;
      ++directed[{a, b}];
      ++undirected[std::minmax(a, b)];
    }
  }
  Counted c;
  c.edges = undirected.size();
  for (const auto& [edge, uses] : undirected) {
    c.closed &= uses == 2;
    c.edge_manifold &= uses <= 2;
  }
  for (const auto& [edge, uses] : directed) c.oriented &= uses == 1;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (fans_at(mesh.triangles, VertexIndex(v)) > 1) ++c.pinched_vertices;
  }
  return c;
}

TEST(Topology, agrees_with_a_count_by_maps_on_random_triangles) {
  std::mt19937 random(5);
  for (int run = 0; run < 300; ++run) {
    TriangleMesh mesh;
    const std::size_t vertices = 4 + random() % 6;
    mesh.positions.resize(vertices);
    std::set<std::set<std::size_t>> seen;
    for (std::size_t i = 0; i < 2 + random() % 12; ++i) {
      const std::size_t a = random() % vertices;
      const std::size_t b = random() % vertices;
      const std::size_t c = random() % vertices;
      if (a == b || b == c || a == c || !seen.insert({a, b, c}).second) continue;
      mesh.triangles.push_back(triangle(a, b, c));
    }
    if (mesh.triangles.empty()) continue;
    const Topology t = topology_of(mesh);
    const Counted c = counted(mesh);
    ASSERT_EQ(t.edges, c.edges);
    ASSERT_EQ(t.closed, c.closed);
    ASSERT_EQ(t.edge_manifold, c.edge_manifold);
    ASSERT_EQ(t.oriented, c.oriented);
    ASSERT_EQ(t.non_manifold_vertices, c.pinched_vertices);
  }
}

TEST(HalfEdges, mates_run_in_opposite_directions) {
  const TriangleMesh mesh = testing::torus_mesh(5, 4);
  const HalfEdges half_edges(mesh.triangles, mesh.positions.size());
  EXPECT_EQ(half_edges.edges(), mesh.triangles.size() * 3 / 2);
  for (std::size_t h = 0; h < 3 * mesh.triangles.size(); ++h) {
    const HalfEdgeIndex mate = half_edges.mate(HalfEdgeIndex(h));
    ASSERT_TRUE(mate.valid());
    EXPECT_EQ(half_edges.mate(mate), HalfEdgeIndex(h));
    EXPECT_EQ(mesh.triangles[h / 3][h % 3], mesh.triangles[mate / 3][(mate % 3 + 1) % 3]);
  }
}

TEST(OrientOutwards, turns_each_closed_part_by_its_own_volume) {
  TriangleMesh inward = testing::tetrahedron();
  for (Triangle& t : inward.triangles) std::swap(t[0], t[1]);
  TriangleMesh both = testing::together(testing::tetrahedron(), inward, {10, 0, 0});
  orient_outwards(both);
  EXPECT_NEAR(signed_volume(both), 2 * signed_volume(testing::tetrahedron()), 1e-12);
}

TEST(OrientOutwards, turns_an_open_part_away_from_its_centre) {
  TriangleMesh cup = testing::tetrahedron();
  cup.triangles.pop_back();
  const std::vector<Triangle> outward = cup.triangles;
  for (Triangle& t : cup.triangles) std::swap(t[1], t[2]);
  TriangleMesh known = cup;
  orient_outwards(cup);
  EXPECT_EQ(cup.triangles, outward);
  orient_oriented_outwards(known);
  EXPECT_EQ(known.triangles, outward);
}

TEST(SortTriangles, gives_the_same_bytes_for_the_same_set) {
  TriangleMesh a = testing::tetrahedron();
  TriangleMesh b = a;
  std::ranges::reverse(b.triangles);
  for (Triangle& t : b.triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
  sort_triangles(a);
  sort_triangles(b);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_GT(signed_volume(b), 0);
}

}  // namespace
}  // namespace surfaced
