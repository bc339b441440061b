// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/facing.hpp"

#include <gtest/gtest.h>

#include <random>

#include "support/shapes.hpp"

namespace surfaced {
namespace {

void turn(TriangleMesh& mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

/// Of a torus about the z axis, along the faces or against them.
void add_normals(TriangleMesh& mesh, float sign) {
  std::vector<Point3> facing(mesh.positions.size(), Point3{});
  for (const Triangle& t : mesh.triangles) {
    const Point3 f = cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    for (const VertexIndex v : t) {
      for (std::size_t axis = 0; axis < 3; ++axis) facing[v][axis] += f[axis];
    }
  }
  for (const Point3& f : facing) {
    Normal3 n{};
    for (std::size_t axis = 0; axis < 3; ++axis) n.at(axis) = sign * static_cast<float>(f[axis] / norm(f));
    mesh.normals.push_back(n);
  }
}

/// Share of the triangles that face the way their corners' normals do.
double agreeing(const TriangleMesh& mesh) {
  std::size_t count = 0;
  for (const Triangle& t : mesh.triangles) {
    const Point3 f = cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    bool all = true;
    for (const VertexIndex v : t) {
      const Normal3& n = mesh.normals[v];
      all = all && dot(f, {n[0], n[1], n[2]}) > 0;
    }
    count += all ? 1U : 0U;
  }
  return static_cast<double>(count) / static_cast<double>(mesh.triangles.size());
}

/// A terrain over the plane across `axis`, its front on the side of the sign.
TriangleMesh terrain(std::size_t axis, bool up) {
  TriangleMesh mesh;
  constexpr std::size_t kSide = 12;
  for (std::size_t i = 0; i < kSide; ++i) {
    for (std::size_t j = 0; j < kSide; ++j) {
      const auto x = static_cast<double>(i);
      const auto y = static_cast<double>(j);
      Point3 p{};
      p[(axis + 1) % 3] = x;
      p[(axis + 2) % 3] = y;
      p[axis] = 0.02 * (x - 5) * (x - 5) - 0.3 * y;
      mesh.positions.push_back(p);
    }
  }
  for (std::size_t i = 0; i + 1 < kSide; ++i) {
    for (std::size_t j = 0; j + 1 < kSide; ++j) {
      const std::size_t a = i * kSide + j;
      mesh.triangles.push_back(testing::triangle(a, a + kSide, a + kSide + 1));
      mesh.triangles.push_back(testing::triangle(a, a + kSide + 1, a + 1));
    }
  }
  if (!up) turn(mesh);
  return mesh;
}

double upward_area(const TriangleMesh& mesh, std::size_t axis) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    sum += cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]])[axis];
  }
  return sum / 2;
}

TEST(Face, follows_normals_that_agree_also_inwards) {
  TriangleMesh torus = testing::torus_mesh(40, 20);
  add_normals(torus, -1);
  const double volume = signed_volume(torus);
  const Facing facing = face(torus, {});
  EXPECT_DOUBLE_EQ(signed_volume(torus), -volume);
  EXPECT_EQ(facing.turned, torus.triangles.size());
  EXPECT_EQ(facing.triangles[0], torus.triangles.size());
  EXPECT_TRUE(facing.normals && facing.normals->trusted && facing.normals->turned == 0);
  EXPECT_EQ(agreeing(torus), 1);
}

TEST(Face, turns_the_few_normals_that_oppose_the_others) {
  TriangleMesh torus = testing::torus_mesh(40, 20);
  add_normals(torus, 1);
  for (std::size_t v = 0; v < 100; ++v) {
    for (float& x : torus.normals[v]) x = -x;
  }
  const std::vector<Triangle> before = torus.triangles;
  const Facing facing = face(torus, {});
  EXPECT_EQ(torus.triangles, before);
  EXPECT_EQ(facing.normals->turned, 100U);
  EXPECT_DOUBLE_EQ(facing.normals->agreeing, 0.875);
  EXPECT_EQ(agreeing(torus), 1);
}

TEST(Face, does_not_heed_random_signs_nor_directions_and_leaves_no_normal_against_its_faces) {
  std::mt19937 random(3);
  for (const bool along : {false, true}) {
    TriangleMesh torus = testing::torus_mesh(40, 20);
    add_normals(torus, 1);
    for (std::size_t v = 0; v < torus.normals.size(); ++v) {
      Normal3& n = torus.normals[v];
      // Along the surface: around the axis of the torus.
      const Point3& p = torus.positions[v];
      const auto length = static_cast<float>(std::hypot(p[0], p[1]));
      if (along) n = {static_cast<float>(-p[1]) / length, static_cast<float>(p[0]) / length, 0};
      if (random() % 2 == 0) {
        for (float& x : n) x = -x;
      }
    }
    const std::vector<Triangle> before = torus.triangles;
    const Facing facing = face(torus, {});
    EXPECT_EQ(torus.triangles, before);
    EXPECT_EQ(facing.triangles[3], before.size());
    EXPECT_FALSE(facing.certainty);
    EXPECT_FALSE(facing.normals->trusted);
    EXPECT_EQ(facing.normals->computed, along ? torus.normals.size() : 0);
    EXPECT_EQ(agreeing(torus), 1);
  }
}

TEST(Face, turns_a_height_field_up_along_z_or_y) {
  for (const std::size_t axis : {std::size_t{1}, std::size_t{2}}) {
    for (const bool up : {false, true}) {
      TriangleMesh mesh = terrain(axis, up);
      const Facing facing = face(mesh, {});
      EXPECT_GT(upward_area(mesh, axis), 0);
      EXPECT_EQ(facing.triangles[2], mesh.triangles.size());
      EXPECT_EQ(facing.turned, up ? 0 : mesh.triangles.size());
    }
  }
  TriangleMesh wall = terrain(0, false);
  const std::vector<Triangle> before = wall.triangles;
  face(wall, {});
  EXPECT_EQ(wall.triangles, before);
}

TEST(Face, looks_at_the_viewpoint_from_inside_of_a_room) {
  TriangleMesh room = testing::tetrahedron();
  const double volume = signed_volume(room);
  const Point3 inside{0.2, 0.2, 0.2};
  const Facing facing = face(room, {.viewpoint = inside});
  EXPECT_DOUBLE_EQ(signed_volume(room), -volume);
  EXPECT_DOUBLE_EQ(*facing.certainty, 1);
  // From outside half of a body is seen, which tells nothing.
  TriangleMesh body = testing::torus_mesh(40, 20);
  const double outside = signed_volume(body);
  EXPECT_EQ(face(body, {.viewpoint = Point3{0, 0, 50}}).triangles[3], body.triangles.size());
  EXPECT_DOUBLE_EQ(signed_volume(body), outside);
}

TEST(Face, obeys_what_is_asked) {
  TriangleMesh mesh = terrain(2, true);
  face(mesh, {.rule = FacingRule::flip});
  EXPECT_LT(upward_area(mesh, 2), 0);
  face(mesh, {.rule = FacingRule::up});
  EXPECT_GT(upward_area(mesh, 2), 0);
  face(mesh, {.rule = FacingRule::viewpoint, .viewpoint = Point3{5, 5, -100}});
  EXPECT_LT(upward_area(mesh, 2), 0);
  TriangleMesh torus = testing::torus_mesh(40, 20);
  const double volume = signed_volume(torus);
  add_normals(torus, -1);
  turn(torus);
  face(torus, {.rule = FacingRule::outwards});
  EXPECT_DOUBLE_EQ(signed_volume(torus), volume);
  EXPECT_EQ(agreeing(torus), 1);
}

/// Parts are turned one by one; of three vertices two agree by chance, so small parts do not make normals trusted.
TEST(Face, judges_normals_by_the_larger_parts) {
  TriangleMesh torus = testing::torus_mesh(40, 20);
  add_normals(torus, 1);
  std::mt19937 random(5);
  for (Normal3& n : torus.normals) {
    if (random() % 2 == 0) {
      for (float& x : n) x = -x;
    }
  }
  TriangleMesh mesh = torus;
  for (std::size_t i = 0; i < 400; ++i) {
    const std::size_t a = mesh.positions.size();
    for (const Point3& p : {Point3{10, 0, 0}, Point3{11, 0, 0}, Point3{10, 1, 0}}) {
      mesh.positions.push_back({p[0], p[1], static_cast<double>(i)});
      mesh.normals.push_back({0, 0, 1});
    }
    mesh.triangles.push_back(testing::triangle(a, a + 1, a + 2));
  }
  EXPECT_FALSE(face(mesh, {}).normals->trusted);
}

}  // namespace
}  // namespace surfaced
