// SPDX-License-Identifier: GPL-3.0-or-later
// Openings and fronts, one rule for all methods.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "reconstruction/reconstruction.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

PointCloud cloud_of(RawCloud raw) { return make_cloud(std::move(raw)).value(); }

Result<Reconstruction> made(const PointCloud& cloud, std::string_view method, const Json& parameters = Json::object()) {
  Context context;
  const MethodInfo& info = **find_method(method);
  return run(cloud, info, *check_parameters(info, parameters), context);
}

std::vector<Point3> hemisphere() {
  std::vector<Point3> points = testing::sphere_points(3000);
  std::erase_if(points, [](const Point3& p) { return p[2] < 0.02; });
  return points;
}

TEST(Openings, stay_open_with_all_methods_that_keep_them_and_are_named) {
  const PointCloud cloud = cloud_of(testing::raw_cloud(hemisphere()));
  for (const char* const method : {"local-delaunay", "intrinsic-delaunay", "advancing-front", "scale-space"}) {
    const auto open = made(cloud, method);
    ASSERT_TRUE(open.ok()) << method;
    const Topology topology = topology_of(open->mesh);
    EXPECT_EQ(topology.boundary_loops, 1U) << method;
    EXPECT_TRUE(topology.vertex_manifold) << method;
    EXPECT_EQ(topology.vertices, cloud.size()) << method;
  }
  EXPECT_THAT(made(cloud, "local-delaunay")->warnings, Contains(HasSubstr("1 opening left open")));
  const auto spanned = made(cloud, "local-delaunay", {{"openings", "close"}});
  EXPECT_TRUE(topology_of(spanned->mesh).closed);
  EXPECT_THAT(spanned->warnings, Contains(HasSubstr("1 opening spanned by edges up to")));
}

TEST(Openings, are_none_of_a_closed_cloud) {
  const PointCloud cloud = cloud_of(testing::raw_cloud(testing::sphere_points(3000)));
  for (const char* const method : {"local-delaunay", "intrinsic-delaunay", "advancing-front"}) {
    const auto closed = made(cloud, method);
    EXPECT_TRUE(topology_of(closed->mesh).closed) << method;
    EXPECT_THAT(closed->warnings, Not(Contains(HasSubstr("opening")))) << method;
  }
}

TEST(Orient, turns_a_body_by_the_normals_of_its_cloud_unless_outwards_is_asked) {
  RawCloud raw = testing::raw_cloud(testing::sphere_points(1000));
  for (const Point3& p : raw.positions) {
    raw.normals.push_back({static_cast<float>(-p[0]), static_cast<float>(-p[1]), static_cast<float>(-p[2])});
  }
  const PointCloud cloud = cloud_of(std::move(raw));
  for (const MethodInfo& method : methods()) {
    // Those with vertices of their own: poisson follows the normals from the beginning, alpha-wrap knows none.
    if (method.id == "poisson" || method.id == "alpha-wrap") continue;
    const auto inwards = made(cloud, method.id);
    EXPECT_LT(signed_volume(inwards->mesh), -4) << method.id;
    EXPECT_EQ(inwards->orientation.at("normals").at("agreeing"), 1) << method.id;
    const auto outwards = made(cloud, method.id, {{"orient", "outwards"}});
    EXPECT_GT(signed_volume(outwards->mesh), 4) << method.id;
    EXPECT_EQ(outwards->orientation.at("normals").at("turned"), outwards->mesh.positions.size()) << method.id;
  }
}

TEST(Orient, looks_towards_a_sensor_of_the_file_or_of_the_caller) {
  RawCloud raw = testing::raw_cloud(testing::sphere_points(1000));
  raw.source.viewpoint = Point3{0.1, 0.2, 0.3};
  const auto inwards = made(cloud_of(std::move(raw)), "local-delaunay");
  EXPECT_LT(signed_volume(inwards->mesh), -4);
  EXPECT_GT(inwards->orientation.at("triangles_by").at("viewpoint"), 1000);
  const PointCloud cloud = cloud_of(testing::raw_cloud(testing::sphere_points(1000)));
  EXPECT_GT(signed_volume(made(cloud, "local-delaunay")->mesh), 4);
  for (const char* const place : {"viewpoint=0,0,0", "viewpoint=-1e-1,0.25,.5"}) {
    const auto checked = check_parameters(**find_method("local-delaunay"), {{"orient", place}});
    if (std::string_view(place).ends_with(",.5")) {
      EXPECT_FALSE(checked.ok()) << place;
    } else {
      EXPECT_LT(signed_volume(made(cloud, "local-delaunay", {{"orient", place}})->mesh), -4) << place;
    }
  }
}

TEST(Orient, turns_a_dome_up_and_flips_it_when_asked) {
  const PointCloud cloud = cloud_of(testing::raw_cloud(hemisphere()));
  const auto up = made(cloud, "local-delaunay");
  EXPECT_EQ(up->orientation.at("triangles_by").at("up"), up->mesh.triangles.size());
  EXPECT_GT(up->orientation.at("certainty"), 0.99);
  const auto down = made(cloud, "local-delaunay", {{"orient", "flip"}});
  EXPECT_NE(down->mesh.triangles, up->mesh.triangles);
}

}  // namespace
}  // namespace surfaced
