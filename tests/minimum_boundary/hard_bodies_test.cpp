// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies of known truth that are hard for other reasons than noise alone: deep cavities, thin walls, parts in contact,
// and cages that an islet nearly let win.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "minimum_boundary/minimum_boundary.hpp"
#include "support/known_bodies.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using std::numbers::pi;
using testing::random_unit;

MinimumBoundaryResult reconstructed(const std::vector<Point3>& points) {
  Context context(2);
  return *minimum_boundary(*make_cloud(testing::raw_cloud(points)), {}, context);
}

void expect_body(const std::vector<Point3>& points, std::int64_t genus, double volume, const std::string& what) {
  const MinimumBoundaryResult result = reconstructed(points);
  EXPECT_EQ(result.statistics.genus, genus) << what;
  EXPECT_EQ(result.statistics.components, 1U) << what;
  EXPECT_LE(result.statistics.interior_vertices, points.size() / 500) << what;
  EXPECT_NEAR(testing::volume_of(result.mesh) / volume, 1, 0.15) << what;
}

testing::KnownBody body_named(const std::string& name) {
  for (testing::KnownBody& body : testing::known_bodies()) {
    if (body.name == name) return body;
  }
  ADD_FAILURE() << "no body " << name;
  return {};
}

/// Of a round cup of height 2 and radius 1 with a cavity of radius 0.6 down to the given depth.
std::vector<Point3> cup_points(std::size_t n, double depth, std::uint32_t seed) {
  const double hollow = 0.6;
  const double outer_wall = 2 * pi * 2;
  const double inner_wall = 2 * pi * hollow * depth;
  const double bottom = pi;
  const double top = pi * (1 - hollow * hollow);
  const double floor = pi * hollow * hollow;
  std::mt19937 random(seed);
  const auto disk = [&](double from, double to, double z) {
    const double r = std::sqrt(from * from + (to * to - from * from) * random_unit(random));
    const double angle = 2 * pi * random_unit(random);
    return Point3{r * std::cos(angle), r * std::sin(angle), z};
  };
  const auto wall = [&](double r, double from, double to) {
    const double angle = 2 * pi * random_unit(random);
    return Point3{r * std::cos(angle), r * std::sin(angle), from + (to - from) * random_unit(random)};
  };
  std::vector<Point3> points;
  while (points.size() < n) {
    double at = random_unit(random) * (outer_wall + inner_wall + bottom + top + floor);
    if ((at -= outer_wall) < 0) {
      points.push_back(wall(1, 0, 2));
    } else if ((at -= inner_wall) < 0) {
      points.push_back(wall(hollow, 2 - depth, 2));
    } else if ((at -= bottom) < 0) {
      points.push_back(disk(0, 1, 0));
    } else if ((at -= top) < 0) {
      points.push_back(disk(hollow, 1, 2));
    } else {
      points.push_back(disk(0, hollow, 2 - depth));
    }
  }
  return points;
}

TEST(HardBodies, a_cavity_four_times_as_deep_as_its_wall_is_thick_stays_open) {
  for (const double depth : {1.0, 1.6}) {
    expect_body(cup_points(2500, depth, 31), 0, pi * (2 - 0.36 * depth), "cup, depth " + std::to_string(depth));
  }
}

TEST(HardBodies, a_plate_two_spacings_thick_stays_a_plate) {
  const testing::KnownBody plate = testing::box_body("thin plate", {2, 2, 0.12});
  expect_body(testing::points_of(plate, 2500, 0, 32), 0, plate.volume, plate.name);
}

TEST(HardBodies, two_balls_in_contact_keep_their_volume_and_get_no_handle) {
  std::vector<Point3> points = testing::sphere_points(900);
  for (const Point3& p : testing::sphere_points(900, {2, 0, 0})) points.push_back(p);
  const MinimumBoundaryResult result = reconstructed(points);
  EXPECT_EQ(result.statistics.genus, 0);
  EXPECT_LE(result.statistics.components, 2U);
  EXPECT_NEAR(testing::volume_of(result.mesh) / (8 * pi / 3), 1, 0.05);
}

// The body had an islet beside it, and a cage in one component won for that.
TEST(HardBodies, an_islet_beside_the_body_does_not_let_a_cage_win) {
  const testing::KnownBody box = body_named("box");
  EXPECT_NEAR(testing::volume_of(reconstructed(testing::points_of(box, 1000, 0.35, 504)).mesh) / box.volume, 1, 0.25);
}

}  // namespace
}  // namespace surfaced
