// SPDX-License-Identifier: GPL-3.0-or-later
// Openings and fronts, one rule for all methods.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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

TEST(FilledFromPoints, holes_are_as_dense_as_the_points_around_and_lie_on_the_surface) {
  const std::vector<Point3> whole = testing::sphere_points(10'000);
  std::vector<Point3> points = whole;
  std::erase_if(points, [](const Point3& p) { return norm(p - Point3{0.6, 0.64, 0.48}) < 0.2; });
  const auto lost = static_cast<double>(whole.size() - points.size());
  const PointCloud cloud = cloud_of(testing::raw_cloud(points));
  for (const char* const method : {"local-delaunay", "intrinsic-delaunay", "advancing-front", "scale-space"}) {
    const auto filled = made(cloud, method, {{"fill_holes", "all"}});
    ASSERT_TRUE(filled.ok()) << method;
    EXPECT_TRUE(topology_of(filled->mesh).closed) << method;
    const auto added = filled->hole_filling.at("vertices_added").get<double>();
    EXPECT_NEAR(added, lost, 0.25 * lost) << method;
    double off = 0;
    for (std::size_t v = cloud.size(); v < filled->mesh.positions.size(); ++v) {
      off += std::abs(norm(filled->mesh.positions[v]) - 1) / added;
    }
    EXPECT_LT(off, 0.0005) << method;  // of the diameter 0.00025
  }
}

TEST(FilledFromPoints, gaps_between_random_points_are_no_holes) {
  std::size_t opened = 0;
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    const auto filled = made(cloud_of(testing::raw_cloud(testing::random_torus(4000, seed))), "local-delaunay",
                             {{"fill_holes", "all"}});
    ASSERT_TRUE(filled.ok());
    opened += filled->hole_filling.at("spans_opened").get<std::size_t>();
  }
  EXPECT_LE(opened, 2U);
}

TEST(FilledFromPoints, triangles_larger_than_the_sampling_radius_are_counted_in_the_filled_mesh) {
  std::vector<Point3> points = testing::sphere_points(4000);
  std::erase_if(points, [](const Point3& p) { return p[2] > 0.8; });
  constexpr double kEpsilon = 0.05;
  const auto filled = made(cloud_of(testing::raw_cloud(points)), "intrinsic-delaunay",
                           {{"fill_holes", "all"}, {"upsample", "jet"}, {"epsilon", kEpsilon}});
  ASSERT_TRUE(filled.ok());
  ASSERT_GT(filled->hole_filling.at("filled"), 0);
  std::size_t large = 0;
  for (const Triangle& t : filled->mesh.triangles) {
    const auto length = [&](std::size_t i) {
      return norm(filled->mesh.positions[t.at(i)] - filled->mesh.positions[t.at((i + 1) % 3)]);
    };
    const double s = (length(0) + length(1) + length(2)) / 2;
    const double area = std::sqrt(s * (s - length(0)) * (s - length(1)) * (s - length(2)));
    large += length(0) * length(1) * length(2) / (4 * area) > kEpsilon ? 1U : 0U;
  }
  EXPECT_EQ(filled->statistics.at("upsampling").at("large_triangles"), large);
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
