// SPDX-License-Identifier: GPL-3.0-or-later
// Where the points of a patch go, by the Laplacian that normals and membranes are harmonic for.
#include "hole_filling/refinement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "hole_filling/angle_front.hpp"

namespace surfaced::filling {
namespace {

/// A cap cut from the unit sphere at an angle of about `opening` from its pole, with a rim as rough as asked.
Hole hole_in_sphere(double opening, std::uint32_t corners, double rough) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> shift(-rough, rough);
  const auto on_sphere = [](double tilt, double turn) {
    return Point3{std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)};
  };
  Hole hole;
  const double step = 2 * std::numbers::pi / corners;
  for (std::uint32_t i = 0; i < corners; ++i) {
    hole.corners.push_back(on_sphere(opening * (1 + step * shift(random)), step * (i + shift(random))));
    hole.normals.push_back(hole.corners.back());
    hole.beyond.push_back(on_sphere(opening * (1 + step), step * (i + 0.5)));
  }
  hole.spacings.assign(corners, opening * step);
  hole.joined = [](std::uint32_t, std::uint32_t) { return false; };
  return hole;
}

double mean_distance_to_sphere(const Patch& patch, const Hole& hole) {
  double sum = 0;
  for (std::size_t i = hole.corners.size(); i < patch.points.size(); ++i) sum += std::abs(norm(patch.points[i]) - 1);
  return sum / static_cast<double>(patch.points.size() - hole.corners.size());
}

TEST(Refinement, comes_as_near_to_a_sphere_over_a_rough_rim_with_cotangents_but_not_with_belkin_s_weights) {
  for (const double rough : {0.0, 0.3}) {
    const Hole hole = hole_in_sphere(0.4, 48, rough);
    const auto covered = cover_by_angles(hole, 10'000);
    ASSERT_TRUE(covered);
    const auto distance = [&](Rotation rotation, Weights harmonic) {
      Patch patch = *covered;
      refine(patch, hole, rotation, harmonic);
      return mean_distance_to_sphere(patch, hole);
    };
    const double cotangent = distance(Rotation::normal, cotangent_weights);
    const double belkin = distance(Rotation::normal, belkin_weights);
    const std::string at = rough > 0 ? "_rough" : "_even";
    RecordProperty("normal_cotangent" + at, std::to_string(cotangent));
    RecordProperty("normal_belkin" + at, std::to_string(belkin));
    RecordProperty("none_cotangent" + at, std::to_string(distance(Rotation::none, cotangent_weights)));
    RecordProperty("none_belkin" + at, std::to_string(distance(Rotation::none, belkin_weights)));
    EXPECT_LT(cotangent, 0.003);
    if (rough > 0) {
      EXPECT_GT(belkin, 2 * cotangent);
    }
  }
}

}  // namespace
}  // namespace surfaced::filling
