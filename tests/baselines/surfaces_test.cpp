// SPDX-License-Identifier: GPL-3.0-or-later
// scale-space, poisson and alpha-wrap: what holds for every result.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>
#include <random>

#include "base/vectors.hpp"
#include "baselines/baselines.hpp"
#include "support/cancel_at.hpp"
#include "support/nasty_clouds.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

Result<TriangleMesh> wrapped(const PointCloud& cloud, Context& context) {
  Result<AlphaWrapResult> result = alpha_wrap(cloud, {}, context);
  if (!result) return std::move(result).error();
  return std::move(result->mesh);
}
Result<TriangleMesh> by_poisson(const PointCloud& cloud, Context& context) {
  Result<PoissonResult> result = poisson(cloud, {}, context);
  if (!result) return std::move(result).error();
  return std::move(result->mesh);
}
Result<TriangleMesh> by_scale_space(const PointCloud& cloud, Context& context) {
  return scale_space(cloud, {}, context);
}

Result<TriangleMesh> by_advancing_front(const PointCloud& cloud, Context& context) {
  return advancing_front(cloud, {}, context);
}

using Way = Result<TriangleMesh> (*)(const PointCloud&, Context&);
struct Named {
  const char* name;
  Way make;
};
constexpr std::array kMethods{Named{"alpha-wrap", wrapped}, Named{"poisson", by_poisson},
                              Named{"scale-space", by_scale_space}};

PointCloud cloud_of(std::vector<Point3> points) { return *make_cloud(testing::raw_cloud(std::move(points))); }

double distance_to_torus(const Point3& p) { return std::abs(std::hypot(std::hypot(p[0], p[1]) - 1, p[2]) - 0.3); }

/// Red above, blue below; normals of the unit sphere.
RawCloud painted_sphere(std::size_t n) {
  RawCloud raw = testing::raw_cloud(testing::sphere_points(n));
  for (const Point3& p : raw.positions) {
    raw.normals.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    raw.colors.push_back(p[2] > 0 ? Color4{255, 0, 0, 255} : Color4{0, 0, 255, 255});
  }
  return raw;
}

TEST(CgalSurfaces, close_around_a_torus_with_its_genus) {
  const PointCloud cloud = cloud_of(testing::torus_points(96, 32));
  for (const auto& [name, make] : kMethods) {
    Context context;
    const auto mesh = make(cloud, context);
    ASSERT_TRUE(mesh) << name << ": " << mesh.error().detail;
    const Topology topology = topology_of(*mesh);
    EXPECT_TRUE(topology.closed && topology.edge_manifold && topology.vertex_manifold && topology.oriented) << name;
    EXPECT_EQ(topology.components, 1U) << name;
    EXPECT_EQ(topology.genus, 1) << name;
    EXPECT_GT(signed_volume(*mesh), 1.5) << name << ": faces outwards";
  }
}

TEST(CgalSurfaces, lie_within_half_a_spacing_of_the_truth_and_poisson_within_less_than_the_noise) {
  constexpr double kNoise = 0.01;
  const PointCloud cloud = cloud_of(testing::random_torus(6000, 5, kNoise));  // spacing 0.03
  Context context;
  const auto smooth = by_poisson(cloud, context);
  ASSERT_TRUE(smooth) << smooth.error().detail;
  double sum = 0;
  for (const Point3& p : smooth->positions) sum += distance_to_torus(p);
  EXPECT_LT(sum / static_cast<double>(smooth->positions.size()), 0.5 * kNoise);
  const auto exact = by_scale_space(cloud, context);
  ASSERT_TRUE(exact) << exact.error().detail;
  EXPECT_EQ(exact->positions, cloud.positions);
  EXPECT_GT(exact->triangles.size(), 11'000U);
}

TEST(CgalSurfaces, alpha_wrap_has_every_point_inside_at_its_offset) {
  const PointCloud cloud = cloud_of(testing::sphere_points(2000));
  Context context;
  const auto result = alpha_wrap(cloud, {.alpha = 3, .offset = 1}, context);
  ASSERT_TRUE(result) << result.error().detail;
  EXPECT_EQ(result->alpha, 3);
  for (const Point3& p : result->mesh.positions) {
    EXPECT_GT(norm(p), 1);
    EXPECT_LT(norm(p), 1.15);
  }
}

TEST(CgalSurfaces, alpha_wrap_refines_only_as_far_as_it_does_not_leak) {
  std::vector<Point3> dense = testing::sphere_points(4000);
  Context context;
  EXPECT_EQ(alpha_wrap(cloud_of(dense), {}, context)->alpha, 3);
  std::erase_if(dense, [](const Point3& p) { return p[2] > 0.94; });  // about 14 spacings across
  const auto holed = alpha_wrap(cloud_of(dense), {}, context);
  ASSERT_TRUE(holed);
  EXPECT_GT(holed->alpha, 3);
  EXPECT_GT(signed_volume(holed->mesh), 3.5);
}

TEST(CgalSurfaces, alpha_wrap_keeps_the_coarser_wrap_where_a_finer_one_has_too_many_vertices) {
  const PointCloud cloud = cloud_of(testing::sphere_points(60));
  constexpr double kOffset = 160;  // a ball of some 1,600 vertices with alpha 12, and four times as many for half of it
  Context context;
  const auto kept = alpha_wrap(cloud, {.alpha = std::nullopt, .offset = kOffset}, context);
  ASSERT_TRUE(kept) << kept.error().detail;
  EXPECT_EQ(kept->alpha, 6);
  EXPECT_TRUE(topology_of(kept->mesh).closed);
  const auto refused = alpha_wrap(cloud, {.alpha = 3, .offset = kOffset}, context);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::method_failed);
  EXPECT_NE(refused.error().detail.find("more than 21800 vertices"), std::string::npos) << refused.error().detail;
}

TEST(CgalSurfaces, carry_normals_and_colours_of_the_nearest_point) {
  const PointCloud cloud = *make_cloud(painted_sphere(2000));
  for (const auto& [name, make] : kMethods) {
    Context context;
    const auto mesh = make(cloud, context);
    ASSERT_TRUE(mesh) << name;
    ASSERT_EQ(mesh->colors.size(), mesh->positions.size()) << name;
    ASSERT_EQ(mesh->normals.size(), mesh->positions.size()) << name;
    for (std::size_t v = 0; v < mesh->positions.size(); ++v) {
      const double z = mesh->positions[v][2];
      if (std::abs(z) > 0.1) {
        EXPECT_EQ(mesh->colors[v][0], z > 0 ? 255 : 0) << name;
      }
    }
  }
}

TEST(CgalSurfaces, poisson_keeps_a_bowl_open_unless_told_otherwise) {
  std::vector<Point3> bowl = testing::sphere_points(4000);
  std::erase_if(bowl, [](const Point3& p) { return p[2] > 0; });
  const PointCloud cloud = cloud_of(bowl);
  Context context;
  const auto open = poisson(cloud, {}, context);
  const auto whole = poisson(cloud, {.trim = std::nullopt}, context);
  ASSERT_TRUE(open && whole);
  EXPECT_EQ(topology_of(open->mesh).boundary_loops, 1U);
  EXPECT_TRUE(topology_of(open->mesh).vertex_manifold);
  EXPECT_TRUE(topology_of(whole->mesh).closed);
}

TEST(CgalSurfaces, poisson_finds_every_part) {
  std::vector<Point3> points = testing::sphere_points(3000);
  for (const Point3& p : testing::sphere_points(300, {9, 0, 0}, 0.3)) points.push_back(p);
  for (const Point3& p : testing::sphere_points(300, {0, -9, 4}, 0.3)) points.push_back(p);
  Context context;
  const auto result = poisson(cloud_of(points), {}, context);
  ASSERT_TRUE(result) << result.error().detail;
  EXPECT_EQ(topology_of(result->mesh).components, 3U);
  EXPECT_EQ(result->points_left_out, 0U);
}

/// Even on faces 0, 1, ... of the cube of side 2.
std::vector<Point3> random_cube(std::size_t n, std::uint32_t seed) {
  std::vector<Point3> points = testing::random_points(n, seed);
  for (std::size_t i = 0; i < n; ++i) points[i].at(i % 3) = i % 6 < 3 ? 1 : -1;
  return points;
}
std::vector<Point3> random_sphere(std::size_t n, std::uint32_t seed) {
  std::vector<Point3> points = testing::random_points(n, seed);
  for (Point3& p : points) p = (1 / norm(p)) * p;
  return points;
}

void expect_a_body(const std::vector<Point3>& points, double volume, std::int64_t genus, const std::string& what) {
  Context context;
  const auto result = poisson(cloud_of(points), {}, context);
  ASSERT_TRUE(result) << what << ": " << result.error().detail;
  const Topology topology = topology_of(result->mesh);
  EXPECT_TRUE(topology.closed && topology.oriented) << what;
  EXPECT_EQ(topology.components, 1U) << what;
  EXPECT_EQ(topology.genus, genus) << what;
  EXPECT_GT(signed_volume(result->mesh), 0.7 * volume) << what << " faces outwards";
  EXPECT_LT(signed_volume(result->mesh), 1.2 * volume) << what;
  EXPECT_EQ(result->points_left_out, 0U) << what;
}

TEST(CgalSurfaces, poisson_closes_small_clouds_of_a_sphere_a_cube_and_a_torus) {
  for (const std::size_t n : {60U, 100U, 230U, 400U, 800U, 1500U}) {
    const std::string points = " of " + std::to_string(n) + " points";
    // Even ones: the library puts no vertex outside, and a cell of 8 spacings holds most of the sphere.
    expect_a_body(testing::sphere_points(n), 4.19, 0, "even sphere" + points);
    for (const std::uint32_t seed : {1U, 2U, 3U}) {
      expect_a_body(random_sphere(n, seed), 4.19, 0, "sphere " + std::to_string(seed) + points);
      expect_a_body(random_cube(n, seed), 8, 0, "cube " + std::to_string(seed) + points);
      // The tube of 300 random points has 14 of them around.
      if (n >= 400) expect_a_body(testing::random_torus(n, seed), 1.78, 1, "torus " + std::to_string(seed) + points);
    }
  }
}

TEST(CgalSurfaces, poisson_keeps_a_small_part_beside_a_large_one_or_counts_its_points) {
  for (const std::size_t n : {60U, 160U, 400U}) {
    for (const double radius : {0.03, 0.1, 0.3}) {  // the large one's spacing is 0.07
      std::vector<Point3> both = testing::sphere_points(3000);
      for (const Point3& p : testing::sphere_points(n, {5, 0, 0}, radius)) both.push_back(p);
      Context context;
      const auto result = poisson(cloud_of(both), {}, context);
      ASSERT_TRUE(result) << result.error().detail;
      const std::size_t components = topology_of(result->mesh).components;
      EXPECT_TRUE(components == 2 || (components == 1 && result->points_left_out == n))
          << n << " points of radius " << radius << ": " << components << " components, left out "
          << result->points_left_out;
      if (radius > 0.2) {
        EXPECT_EQ(components, 2U) << n;
      }
    }
  }
}

TEST(CgalSurfaces, poisson_says_what_to_do_where_it_finds_no_surface) {
  Context context;
  const auto mesh = poisson(cloud_of(testing::sphere_points(100)), {.trim = 1e-6}, context);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::method_failed);
  EXPECT_NE(mesh.error().detail.find("a larger trim"), std::string::npos) << mesh.error().detail;
  EXPECT_EQ(poisson(cloud_of(testing::sphere_points(9)), {}, context).error().code, ErrorCode::too_few_points);
}

TEST(CgalSurfaces, are_the_same_for_any_order_of_the_points_and_number_of_threads) {
  std::vector<Point3> points = testing::random_torus(2500, 9, 0.01);
  const PointCloud first = cloud_of(points);
  std::ranges::shuffle(points, std::mt19937(4));
  const PointCloud second = cloud_of(points);
  for (const auto& [name, make] : kMethods) {
    Context one(1);
    Context three(3);
    const auto a = make(first, one);
    const auto b = make(second, three);
    ASSERT_TRUE(a && b) << name;
    EXPECT_EQ(a->positions, b->positions) << name;
    EXPECT_EQ(a->triangles, b->triangles) << name;
  }
}

/// The points of an integer grid on the sides of a box: as many ties as can be.
std::vector<Point3> grid_on_box(int nx, int ny, int nz) {
  std::vector<Point3> points;
  for (int x = 0; x <= nx; ++x) {
    for (int y = 0; y <= ny; ++y) {
      for (int z = 0; z <= nz; ++z) {
        if (x % nx != 0 && y % ny != 0 && z % nz != 0) continue;
        points.push_back({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
      }
    }
  }
  return points;
}

TEST(CgalSurfaces, are_the_same_whatever_ran_before_in_the_process) {
  const std::vector<PointCloud> clouds{cloud_of(grid_on_box(2, 2, 2)), cloud_of(grid_on_box(9, 5, 3)),
                                       cloud_of(testing::random_points(500, 4)),
                                       cloud_of(testing::torus_points(32, 16)), cloud_of(testing::sphere_points(200))};
  std::mt19937 random(1);
  // What is left of other runs: memory in pieces, so that later addresses come in another order.
  std::vector<std::unique_ptr<char[]>> pieces(400);
  for (const auto& [name, make] :
       {Named{"advancing-front", by_advancing_front}, kMethods[0], kMethods[1], kMethods[2]}) {
    std::vector<std::optional<TriangleMesh>> first(clouds.size());
    for (int round = 0; round < 5; ++round) {
      std::vector<std::size_t> order(clouds.size());
      std::iota(order.begin(), order.end(), std::size_t{0});
      std::ranges::shuffle(order, random);
      for (const std::size_t c : order) {
        for (int i = 0; i < 50; ++i) pieces[random() % pieces.size()] = std::make_unique<char[]>(1 + random() % 5000);
        Context context;
        const auto mesh = make(clouds[c], context);
        ASSERT_TRUE(mesh) << name << " of cloud " << c << ": " << mesh.error().detail;
        if (!first[c]) first[c] = *mesh;
        EXPECT_EQ(mesh->positions, first[c]->positions) << name << " of cloud " << c << ", round " << round;
        EXPECT_EQ(mesh->triangles, first[c]->triangles) << name << " of cloud " << c << ", round " << round;
      }
    }
  }
}

TEST(CgalSurfaces, have_the_same_triangles_at_any_power_of_two_scale) {
  const std::vector<Point3> points = testing::torus_points(96, 32);
  for (const auto& [name, make] : kMethods) {
    Context context;
    const auto reference = make(cloud_of(points), context);
    ASSERT_TRUE(reference) << name << ": " << reference.error().detail;
    ASSERT_FALSE(reference->triangles.empty()) << name;
    for (const int exponent : {-90, 90}) {
      std::vector<Point3> scaled = points;
      for (Point3& p : scaled) {
        for (double& x : p) x = std::ldexp(x, exponent);
      }
      const auto mesh = make(cloud_of(scaled), context);
      ASSERT_TRUE(mesh) << name << ": " << mesh.error().detail;
      EXPECT_EQ(mesh->triangles, reference->triangles) << name << " scaled by 2^" << exponent;
    }
  }
}

TEST(CgalSurfaces, make_a_sound_mesh_of_nasty_clouds_or_say_why_not) {
  for (std::uint64_t number = 0; number < 110; ++number) {
    const testing::NastyCloud nasty = testing::NastyClouds::make(number);
    const PointCloud cloud = cloud_of(nasty.points);
    for (const auto& [name, make] : kMethods) {
      Context context;
      const auto mesh = make(cloud, context);
      if (!mesh) {
        EXPECT_FALSE(mesh.error().detail.empty());
        EXPECT_NE(mesh.error().code, ErrorCode::internal_error);
        EXPECT_NE(make, wrapped) << number << ": alpha-wrap takes anything, but: " << mesh.error().detail;
        continue;
      }
      const Topology topology = topology_of(*mesh);
      EXPECT_TRUE(topology.edge_manifold && topology.oriented) << name << " of " << nasty.kind << " " << number;
      EXPECT_TRUE(make != wrapped || topology.closed) << nasty.kind << " " << number;
      EXPECT_TRUE(make == by_scale_space || topology.vertex_manifold) << name << " of " << nasty.kind << " " << number;
    }
  }
}

TEST(CgalSurfaces, refuse_too_few_points_and_poisson_a_plane) {
  std::vector<Point3> sheet;
  for (const Point3& p : testing::random_points(700, 4)) sheet.push_back({p[0], p[1], 0});
  Context context;
  EXPECT_EQ(by_poisson(cloud_of(sheet), context).error().code, ErrorCode::coplanar);
  for (const auto& [name, make] : kMethods) {
    EXPECT_EQ(make(cloud_of({{0, 0, 0}, {1, 1, 1}}), context).error().code, ErrorCode::too_few_points) << name;
  }
  std::vector<Point3> line;
  for (int i = 0; i < 50; ++i) line.push_back({1.0 * i, 2.0 * i, 3.0 * i});
  const auto of_a_line = scale_space(cloud_of(line), {}, context);
  ASSERT_FALSE(of_a_line) << of_a_line->triangles.size();
  EXPECT_EQ(of_a_line.error().code, ErrorCode::collinear);
}

TEST(CgalSurfaces, stop_within_a_second_of_being_cancelled_in_any_stage) {
  const PointCloud cloud = cloud_of(testing::random_torus(20'000, 3, 0.002));
  for (const auto& [name, make] : kMethods) {
    for (const double when : {0.0, 0.15, 0.4, 0.7}) {
      testing::CancelAt cancel(when);
      Context context(1, cancel.sink(), cancel.flag());
      const auto mesh = make(cloud, context);
      if (mesh) continue;  // was faster than its progress said
      EXPECT_EQ(mesh.error().code, ErrorCode::cancelled) << name << ": " << mesh.error().detail;
      EXPECT_LT(cancel.seconds(), 1) << name << " at " << when;
    }
  }
}

}  // namespace
}  // namespace surfaced
