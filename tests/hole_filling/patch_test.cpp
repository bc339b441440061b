// SPDX-License-Identifier: GPL-3.0-or-later
// What is put into a hole is a disc with that hole's rim, whatever the hole looks like.
#include "hole_filling/patch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "hole_filling/angle_front.hpp"
#include "hole_filling/library_patch.hpp"

namespace surfaced::filling {
namespace {

/// A closed curve of n corners around the z axis, as rough as asked; some pairs of corners count as joined.
Hole rough_hole(std::uint32_t n, double rough, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-rough, rough);
  Hole hole;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.4 * noise(random)) / n;
    const double radius = 1 + 0.7 * noise(random);
    hole.corners.push_back({radius * std::cos(angle), radius * std::sin(angle), noise(random)});
    hole.normals.push_back({noise(random), noise(random), 1});
    hole.beyond.push_back({2 * std::cos(angle), 2 * std::sin(angle), noise(random)});
  }
  hole.spacings.assign(n, 2 * std::sin(std::numbers::pi / n));
  hole.joined = [seed](std::uint32_t i, std::uint32_t j) { return (i * j + i + j + seed) % 5 == 0; };
  return hole;
}

/// What keeps the patch from being a disc with the hole's rim and no joined edge; empty if nothing does.
std::string disc_problem(const Patch& patch, const Hole& hole) {
  const auto n = static_cast<std::uint32_t>(hole.corners.size());
  for (std::uint32_t i = 0; i < n; ++i) {
    if (patch.points[i] != hole.corners[i]) return "a corner has moved";
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> directed;
  std::map<std::uint32_t, std::size_t> degree;
  for (const Corners& t : patch.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!directed.emplace(t[k], t[(k + 1) % 3]).second) return "a directed edge is used twice";
      ++degree[t[k]];
    }
  }
  std::size_t edges = 0;
  std::size_t rim = 0;
  for (const auto& [a, b] : directed) {
    const bool on_rim = a < n && b == (a + 1) % n;
    const bool open = !directed.contains({b, a});
    if (on_rim != open) return "the rim is not the hole's";
    rim += open ? 1 : 0;
    edges += open || a < b ? 1 : 0;
    const bool neighbours = a < n && b < n && ((a + 1) % n == b || (b + 1) % n == a);
    if (a < n && b < n && !neighbours && hole.joined(std::min(a, b), std::max(a, b)))
      return "joined corners are joined again";
  }
  if (rim != n) return "the rim is not the hole's";
  if (degree.size() != patch.points.size()) return "a point is in no triangle";
  if (patch.points.size() + patch.triangles.size() != edges + 1) return "it is no disc";
  return {};
}

TEST(Patches, are_discs_with_the_rim_of_the_hole_and_join_nothing_twice) {
  std::size_t by_angles = 0;
  std::size_t by_library = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    const Hole hole = rough_hole(3 + seed % 40, 0.03 * (seed % 30), seed);
    if (const auto patch = cover_by_angles(hole, 10'000)) {
      EXPECT_EQ(disc_problem(*patch, hole), "") << seed;
      ++by_angles;
    }
    if (const auto patch = cover_by_library(hole)) {
      EXPECT_EQ(disc_problem(*patch, hole), "") << seed;
      ++by_library;
    }
  }
  RecordProperty("by_angles", static_cast<int>(by_angles));
  RecordProperty("by_library", static_cast<int>(by_library));
  EXPECT_GT(by_angles, 100U);
  EXPECT_GT(by_library, 290U);
}

TEST(Patches, follow_the_three_rules) {
  const auto regular = [](std::uint32_t n) {
    Hole hole = rough_hole(n, 0, 0);
    hole.joined = [](std::uint32_t, std::uint32_t) { return false; };
    return hole;
  };
  EXPECT_EQ(cover_by_angles(regular(3), 100)->triangles.size(), 1U);  // 60 degrees: closed
  // 90 degrees: a point at edge length on the bisector, which merges with the corner opposite.
  EXPECT_EQ(cover_by_angles(regular(4), 100)->points.size(), 4U);
  const auto hexagon = cover_by_angles(regular(6), 100);  // 120 degrees: a point at edge length, the centre
  EXPECT_EQ(hexagon->points.size(), 7U);
  EXPECT_EQ(hexagon->triangles.size(), 6U);
  EXPECT_NEAR(norm(hexagon->points[6]), 0, 1e-12);
  EXPECT_GT(cover_by_angles(regular(24), 1000)->points.size(), 40U);  // 165 degrees: two points
}

}  // namespace
}  // namespace surfaced::filling
