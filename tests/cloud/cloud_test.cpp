// SPDX-License-Identifier: GPL-3.0-or-later
#include "cloud/cloud.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>

#include "support/shapes.hpp"

namespace surfaced {
namespace {

using ::testing::HasSubstr;

TEST(MakeCloud, refuses_a_coordinate_that_is_not_finite_and_says_where) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const auto cloud = make_cloud(testing::raw_cloud({{0, 0, 0}, {1, bad, 0}}));
    ASSERT_FALSE(cloud);
    EXPECT_EQ(cloud.error().code, ErrorCode::coordinate_not_finite);
    EXPECT_THAT(cloud.error().detail, HasSubstr("point 1: y"));
  }
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(MakeCloud, leaves_out_points_that_are_not_finite_if_that_is_wanted_and_keeps_what_belongs_to_the_others) {
  RawCloud raw = testing::raw_cloud({{0, kNaN, 0}, {1, 2, 3}, {kInf, 0, 0}, {4, 5, 6}});
  raw.normals = {{kNaN, 0, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  raw.colors = {{1, 1, 1, 1}, {2, 2, 2, 2}, {3, 3, 3, 3}, {4, 4, 4, 4}};
  const auto cloud = make_cloud(raw, 1, Missing::drop);
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->missing, 2U);
  EXPECT_THAT(cloud->warnings, ::testing::ElementsAre(HasSubstr("2 of 4 points left out")));
  ASSERT_EQ(cloud->input_to_vertex.size(), 4U);
  EXPECT_FALSE(cloud->input_to_vertex[0].valid() || cloud->input_to_vertex[2].valid());
  EXPECT_EQ(cloud->positions[cloud->input_to_vertex[3]], (Point3{4, 5, 6}));
  EXPECT_EQ(cloud->colors[cloud->input_to_vertex[3]], (Color4{4, 4, 4, 4}));
  EXPECT_EQ(cloud->normals[cloud->input_to_vertex[1]], (Normal3{0, 0, 1}));
}

TEST(MakeCloud, refuses_a_cloud_of_which_no_point_is_finite) {
  const auto cloud = make_cloud(testing::raw_cloud({{0, kNaN, 0}, {kInf, 0, 0}}), 1, Missing::drop);
  ASSERT_FALSE(cloud);
  EXPECT_EQ(cloud.error().code, ErrorCode::coordinate_not_finite);
}

std::vector<Point3> with_zeros(std::vector<Point3> points, std::size_t zeros) {
  points.insert(points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2), zeros, Point3{});
  return points;
}

TEST(MakeCloud, leaves_out_many_points_at_0_0_0_off_all_others_and_says_how_to_keep_them) {
  std::vector<Point3> far = testing::sphere_points(2000);
  for (Point3& p : far) p[2] += 5;
  for (const std::vector<Point3>& points : {testing::sphere_points(2000), testing::sphere_points(300), far}) {
    const auto cloud = make_cloud(testing::raw_cloud(with_zeros(points, 100)), 1, Missing::drop);
    ASSERT_TRUE(cloud);
    EXPECT_EQ(cloud->size(), points.size());
    EXPECT_EQ(cloud->missing, 100U);
    EXPECT_THAT(cloud->warnings, ::testing::ElementsAre(HasSubstr("missing=refuse keeps them")));
    const auto kept = make_cloud(testing::raw_cloud(with_zeros(points, 100)), 1, Missing::refuse);
    EXPECT_EQ(kept->size(), points.size() + 1);
  }
}

TEST(MakeCloud, leaves_out_points_at_0_0_0_though_few_others_are_near_the_camera) {
  // The floor before a camera, and a wall behind it.
  std::vector<Point3> room;
  for (int i = -20; i < 20; ++i) {
    for (int j = 0; j < 60; ++j) {
      room.push_back({0.05 * i + 0.01, 0.5, 0.3 + 0.05 * j});
      room.push_back({0.05 * i + 0.02, 0.5 - 0.05 * j, 3.3});
    }
  }
  EXPECT_EQ(make_cloud(testing::raw_cloud(with_zeros(room, 100)), 1, Missing::drop)->missing, 100U);
}

TEST(MakeCloud, keeps_points_at_0_0_0_on_the_surface_and_few_of_them_and_corners_of_a_mesh) {
  std::vector<Point3> on = testing::sphere_points(2000);
  const Point3 shift = on[700];
  for (Point3& p : on) p = p - shift;
  EXPECT_EQ(make_cloud(testing::raw_cloud(with_zeros(on, 100)), 1, Missing::drop)->missing, 0U);
  std::vector<Point3> grid;
  for (int i = -20; i < 20; ++i) {
    for (int j = -20; j < 20; ++j) grid.push_back({i + 0.0, j + 0.0, 0});
  }
  EXPECT_EQ(make_cloud(testing::raw_cloud(with_zeros(grid, 100)), 1, Missing::drop)->missing, 0U);
  EXPECT_EQ(make_cloud(testing::raw_cloud(with_zeros(testing::sphere_points(2000), 3)), 1, Missing::drop)->missing, 0U);
  // Rings of 100 points around a pole, which a grid of angles has as often.
  std::vector<Point3> rings;
  for (int ring = 1; ring < 50; ++ring) {
    for (int k = 0; k < 100; ++k) {
      const double latitude = ring * 0.06;
      const double longitude = k * 0.0628318;
      rings.push_back(
          {std::sin(latitude) * std::cos(longitude), std::sin(latitude) * std::sin(longitude), 1 - std::cos(latitude)});
    }
  }
  EXPECT_EQ(make_cloud(testing::raw_cloud(with_zeros(rings, 100)), 1, Missing::drop)->missing, 0U);
  RawCloud mesh = testing::raw_cloud(with_zeros(testing::sphere_points(2000), 100));
  mesh.source.faces = 1;
  EXPECT_EQ(make_cloud(mesh, 1, Missing::drop)->missing, 0U);
}

TEST(MakeCloud, refuses_a_coordinate_beyond_float32_and_gives_value_and_limit) {
  const auto cloud = make_cloud(testing::raw_cloud({{0, 0, 1e299}}));
  ASSERT_FALSE(cloud);
  EXPECT_EQ(cloud.error().code, ErrorCode::coordinate_out_of_range);
  EXPECT_THAT(cloud.error().detail, HasSubstr("1e+299"));
  EXPECT_THAT(cloud.error().detail, HasSubstr("3.4028"));
}

TEST(MakeCloud, merges_duplicates_and_maps_every_input_point) {
  const auto cloud = make_cloud(testing::raw_cloud({{1, 2, 3}, {0.0, 0, 0}, {1, 2, 3}, {-0.0, 0, 0}}));
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->size(), 2U);
  ASSERT_EQ(cloud->input_to_vertex.size(), 4U);
  EXPECT_EQ(cloud->input_to_vertex[0], cloud->input_to_vertex[2]);
  EXPECT_EQ(cloud->input_to_vertex[1], cloud->input_to_vertex[3]);
  EXPECT_FALSE(std::signbit(cloud->positions[cloud->input_to_vertex[3]][0]));
  EXPECT_THAT(cloud->warnings, ::testing::ElementsAre(HasSubstr("2 duplicate points")));
}

TEST(MakeCloud, averages_the_colours_of_duplicates) {
  RawCloud raw = testing::raw_cloud({{0, 0, 0}, {0, 0, 0}});
  raw.colors = {{10, 0, 255, 255}, {20, 1, 255, 255}};
  const auto cloud = make_cloud(raw);
  ASSERT_TRUE(cloud);
  EXPECT_THAT(cloud->colors, ::testing::ElementsAre(Color4{15, 1, 255, 255}));
}

TEST(MakeCloud, drops_normals_that_are_not_finite_with_a_warning) {
  RawCloud raw = testing::raw_cloud({{0, 0, 0}, {1, 0, 0}});
  raw.normals = {{0, 0, 1}, {0, 0, std::numeric_limits<float>::quiet_NaN()}};
  const auto cloud = make_cloud(raw);
  ASSERT_TRUE(cloud);
  EXPECT_TRUE(cloud->normals.empty());
  EXPECT_THAT(cloud->warnings, ::testing::ElementsAre(HasSubstr("the first that of point 1")));
}

struct Shuffled {
  RawCloud raw;
  std::vector<std::size_t> origin;
};

Shuffled shuffled(const RawCloud& raw, std::uint32_t seed) {
  Shuffled result{{}, std::vector<std::size_t>(raw.size())};
  std::iota(result.origin.begin(), result.origin.end(), std::size_t{0});
  std::ranges::shuffle(result.origin, std::mt19937(seed));
  for (const std::size_t i : result.origin) {
    result.raw.positions.push_back(raw.positions[i]);
    result.raw.normals.push_back(raw.normals[i]);
    result.raw.colors.push_back(raw.colors[i]);
  }
  return result;
}

/// Random points on a small lattice, so that many coincide, with attributes.
RawCloud lattice_cloud(std::uint32_t seed) {
  std::mt19937 random(seed);
  RawCloud raw;
  for (int i = 0; i < 200; ++i) {
    const auto draw = [&] { return static_cast<double>(random() % 5) - 2; };
    raw.positions.push_back({draw(), draw(), draw()});
    raw.normals.push_back({static_cast<float>(draw()), static_cast<float>(draw()), 1});
    raw.colors.push_back({static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), 0, 255});
  }
  return raw;
}

TEST(MakeCloud, gives_the_same_cloud_for_any_order_of_the_points) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const RawCloud raw = lattice_cloud(seed);
    const auto reference = make_cloud(raw);
    const Shuffled other = shuffled(raw, seed + 100);
    const auto cloud = make_cloud(other.raw);
    ASSERT_TRUE(reference && cloud);
    EXPECT_EQ(cloud->positions, reference->positions);
    EXPECT_EQ(cloud->normals, reference->normals);
    EXPECT_EQ(cloud->colors, reference->colors);
    for (std::size_t i = 0; i < other.origin.size(); ++i) {
      ASSERT_EQ(cloud->input_to_vertex[i], reference->input_to_vertex[other.origin[i]]);
    }
  }
}

TEST(MakeCloud, keeps_the_order_under_scaling_by_a_power_of_two) {
  const std::vector<Point3> points = testing::random_points(500, 3);
  const auto reference = make_cloud(testing::raw_cloud(points));
  for (const int exponent : {-100, -3, 7, 100}) {
    std::vector<Point3> scaled = points;
    for (Point3& p : scaled) {
      for (double& x : p) x = std::ldexp(x, exponent);
    }
    const auto cloud = make_cloud(testing::raw_cloud(scaled));
    ASSERT_TRUE(cloud);
    EXPECT_EQ(cloud->input_to_vertex, reference->input_to_vertex);
  }
}

TEST(MakeCloud, agrees_with_a_map_of_positions) {
  const RawCloud raw = lattice_cloud(77);
  std::map<Point3, std::size_t> first_of;
  for (std::size_t i = 0; i < raw.size(); ++i) first_of.emplace(raw.positions[i], i);
  const auto cloud = make_cloud(raw);
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->size(), first_of.size());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    EXPECT_EQ(cloud->positions[cloud->input_to_vertex[i]], raw.positions[i]);
  }
}

TEST(MakeCloud, takes_an_empty_cloud) {
  const auto cloud = make_cloud({});
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->size(), 0U);
}

TEST(MakeCloud, takes_the_extremes_of_float32) {
  const double huge = static_cast<double>(std::numeric_limits<float>::max());
  const double tiny = static_cast<double>(std::numeric_limits<float>::denorm_min());
  const auto cloud = make_cloud(testing::raw_cloud({{huge, 0, 0}, {-huge, 0, 0}, {0, tiny, 0}, {0, 0, -tiny}}));
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->size(), 4U);
}

}  // namespace
}  // namespace surfaced
