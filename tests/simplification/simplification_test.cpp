// SPDX-License-Identifier: GPL-3.0-or-later
#include "simplification/simplification.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <set>

#include "base/float32.hpp"
#include "quality/quality.hpp"
#include "support/cancel_at.hpp"
#include "support/codes.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::HasSubstr;

TriangleMesh narrow(TriangleMesh mesh) {
  for (Point3& p : mesh.positions) {
    for (double& x : p) x = static_cast<double>(static_cast<float>(x));
  }
  return mesh;
}

/// A wavy sheet of n x n squares, cut in two, with one boundary loop.
TriangleMesh sheet(std::size_t n) {
  TriangleMesh mesh;
  for (std::size_t i = 0; i <= n; ++i) {
    for (std::size_t j = 0; j <= n; ++j) {
      const double x = static_cast<double>(i) / static_cast<double>(n);
      const double y = static_cast<double>(j) / static_cast<double>(n);
      mesh.positions.push_back({x, y, 0.1 * std::sin(5 * x) * std::cos(4 * y)});
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const std::size_t a = i * (n + 1) + j;
      mesh.triangles.push_back(triangle(a, a + n + 1, a + n + 2));
      mesh.triangles.push_back(triangle(a, a + n + 2, a + 1));
    }
  }
  return mesh;
}

TEST(Simplification, keeps_closedness_genus_components_and_orientation) {
  const TriangleMesh two = together(torus_mesh(60, 40), torus_mesh(50, 30), {3, 0, 0});
  for (const std::size_t goal : {3000U, 500U, 120U}) {
    Context context;
    const auto result = simplified_to(two, goal, context);
    ASSERT_TRUE(result) << detail_of(result);
    const Topology topology = topology_of(result->mesh);
    EXPECT_LE(topology.triangles, goal);
    EXPECT_TRUE(topology.closed && topology.oriented && topology.vertex_manifold);
    EXPECT_EQ(topology.components, 2U);
    EXPECT_EQ(topology.genus, 2);
    EXPECT_GT(signed_volume(result->mesh), 0);
    if (goal < 500) continue;  // self-intersections are not ruled out
    EXPECT_EQ(count_self_intersections(result->mesh), 0U);
  }
}

TEST(Simplification, stops_where_the_topology_forbids_more) {
  Context context;
  const auto sphereless = simplified_to(torus_mesh(20, 12), 4, context);
  ASSERT_TRUE(sphereless) << detail_of(sphereless);
  EXPECT_GE(sphereless->mesh.triangles.size(), 14U) << "no torus has fewer";
  EXPECT_EQ(topology_of(sphereless->mesh).genus, 1);
}

TEST(Simplification, keeps_boundaries_in_number_and_place) {
  Context context;
  const auto result = simplified_to(sheet(40), 300, context);
  ASSERT_TRUE(result) << detail_of(result);
  EXPECT_EQ(topology_of(result->mesh).boundary_loops, 1U);
  EXPECT_LT(result->distance, 0.01);
}

TEST(Simplification, its_distance_holds_at_every_sample_of_both_surfaces) {
  const TriangleMesh before = torus_mesh(40, 24);
  Context context;
  const auto after = simplified_to(before, 400, context);
  ASSERT_TRUE(after) << detail_of(after);
  double sampled = 0;
  for (const auto& [from, to] : {std::pair{&before, &after->mesh}, std::pair{&after->mesh, &before}}) {
    const SurfaceSearch search(*to);
    for (const Triangle& t : from->triangles) {
      for (int i = 0; i <= 6; ++i) {
        for (int j = 0; i + j <= 6; ++j) {
          Point3 p{};
          for (std::size_t axis = 0; axis < 3; ++axis) {
            p[axis] = (i * from->positions[t[0]][axis] + j * from->positions[t[1]][axis] +
                       (6 - i - j) * from->positions[t[2]][axis]) /
                      6;
          }
          sampled = std::max(sampled, search.closest(p).distance);
        }
      }
    }
  }
  EXPECT_GE(after->distance, sampled);
  EXPECT_LE(after->distance, 1.15 * sampled);
}

TEST(Simplification, keeps_within_the_distance_and_uses_it) {
  const TriangleMesh before = torus_mesh(80, 50);
  std::size_t more = before.triangles.size();
  for (const double distance : {0.002, 0.01, 0.05}) {
    Context context;
    const auto result = simplified_within(before, distance, context);
    ASSERT_TRUE(result) << detail_of(result);
    EXPECT_LE(result->distance, distance);
    EXPECT_GE(result->distance, 0.3 * distance);
    EXPECT_LT(result->mesh.triangles.size(), more);
    more = result->mesh.triangles.size();
  }
}

TEST(Simplification, untouched_vertices_keep_their_bits_and_new_ones_are_float32_where_the_old_are) {
  const TriangleMesh before = narrow(torus_mesh(40, 24));
  Context context;
  const auto after = simplified_to(before, 1500, context);
  ASSERT_TRUE(after) << detail_of(after);
  EXPECT_TRUE(fits_float32(after->mesh.positions));
  const std::set<Point3> known(before.positions.begin(), before.positions.end());
  const auto kept = std::ranges::count_if(after->mesh.positions, [&](const Point3& p) { return known.contains(p); });
  EXPECT_GT(kept, 100);
}

TEST(Simplification, is_the_same_far_from_the_origin_and_at_any_power_of_two_scale) {
  const TriangleMesh near = narrow(torus_mesh(40, 24));
  Context context;
  const auto expected = simplified_to(near, 600, context);
  ASSERT_TRUE(expected) << detail_of(expected);
  TriangleMesh far = near;
  TriangleMesh large = near;
  for (Point3& p : far.positions) p = {p[0] + 4194304, p[1] - 4194304, p[2]};
  for (Point3& p : large.positions) p = {p[0] * 1024, p[1] * 1024, p[2] * 1024};
  const auto moved = simplified_to(far, 600, context);
  const auto scaled = simplified_to(large, 600, context);
  ASSERT_TRUE(moved && scaled);
  EXPECT_NEAR(moved->distance, expected->distance, 0.15 * expected->distance);
  EXPECT_EQ(scaled->mesh.triangles, expected->mesh.triangles);
  EXPECT_NEAR(scaled->distance, 1024 * expected->distance, 1e-9);
}

TEST(Simplification, normals_and_colours_are_those_of_the_surface_at_the_new_place) {
  TriangleMesh before = sheet(30);
  for (const Point3& p : before.positions) {
    before.normals.push_back({0, 0, 1});
    before.colors.push_back({static_cast<std::uint8_t>(std::lround(200 * p[0])), 10, 20, 255});
  }
  Context context;
  const auto after = simplified_to(before, 200, context);
  ASSERT_TRUE(after) << detail_of(after);
  ASSERT_EQ(after->mesh.colors.size(), after->mesh.positions.size());
  for (std::size_t v = 0; v < after->mesh.positions.size(); ++v) {
    EXPECT_EQ(after->mesh.normals[v], (Normal3{0, 0, 1}));
    EXPECT_NEAR(after->mesh.colors[v][0], 200 * after->mesh.positions[v][0], 3);
    EXPECT_EQ(after->mesh.colors[v][3], 255);
  }
}

TEST(Simplification, umbrellas_that_share_a_vertex_get_one_each) {
  // Two tori, vertex 0 of the second joined to vertex 0 of the first.
  const TriangleMesh torus = torus_mesh(20, 12);
  TriangleMesh joined = together(torus, torus, {4, 0, 0});
  const auto second = static_cast<std::uint32_t>(torus.positions.size());
  for (Triangle& t : joined.triangles) {
    for (VertexIndex& v : t) v = v.value == second ? VertexIndex(std::size_t{0}) : v;
  }
  ASSERT_EQ(topology_of(joined).non_manifold_vertices, 1U);
  Context context;
  const auto result = simplified_to(joined, 400, context);
  ASSERT_TRUE(result) << detail_of(result);
  EXPECT_TRUE(topology_of(result->mesh).vertex_manifold);
  EXPECT_LE(result->mesh.triangles.size(), 400U);
}

TEST(Simplification, refuses_what_has_no_sides) {
  TriangleMesh mesh = tetrahedron();
  std::swap(mesh.triangles[1][0], mesh.triangles[1][1]);
  Context context;
  const auto result = simplified_to(mesh, 2, context);
  EXPECT_EQ(code_of(result), "method_failed");
  EXPECT_THAT(detail_of(result), HasSubstr("opposite sides"));
}

TEST(Simplification, ends_soon_after_it_is_cancelled) {
  const std::atomic<bool> cancel = true;
  Context context(1, {}, &cancel);
  EXPECT_EQ(code_of(simplified_to(torus_mesh(200, 100), 100, context)), "cancelled");
}

TEST(Simplification, ends_within_a_second_of_being_cancelled_while_it_measures_the_distance) {
  const TriangleMesh before = torus_mesh(200, 100);
  for (const unsigned threads : {1U, 2U}) {
    for (const double when : {0.605, 0.801}) {  // there and back
      testing::CancelAt cancel(when);
      Context context(threads, cancel.sink(), cancel.flag());
      context.enter("simplify", 1);
      EXPECT_EQ(code_of(simplified_to(before, 4000, context)), "cancelled") << when;
      EXPECT_LT(cancel.seconds(), 1) << when;
    }
  }
}

TEST(Simplification, a_mesh_that_is_small_enough_stays_as_it_is) {
  Context context;
  const auto result = simplified_to(tetrahedron(), 4, context);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->mesh.triangles, tetrahedron().triangles);
  EXPECT_EQ(result->distance, 0);
}

}  // namespace
}  // namespace surfaced
