// SPDX-License-Identifier: GPL-3.0-or-later
// Random parts of the shared clouds: how sparse may the points be?
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <random>

#include "io/io.hpp"
#include "minimum_boundary/minimum_boundary.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

struct Known {
  std::string name;
  std::int64_t genus;
};

std::vector<Point3> shared_points(const std::string& name) {
  const std::string path = std::string(SURFACED_SHARED_DATA) + "/" + name + ".ply";
  if (!std::filesystem::exists(path)) return {};
  return make_cloud(*read_cloud(path))->positions;
}

MinimumBoundaryResult reconstruct_part(const std::vector<Point3>& points, std::size_t part, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Point3> some;
  std::ranges::sample(points, std::back_inserter(some), static_cast<std::ptrdiff_t>(points.size() / part), random);
  Context context(2);
  return *minimum_boundary(*make_cloud(testing::raw_cloud(some)), {}, context);
}

TEST(Subsamples, quarters_tenths_and_thirtieths_keep_their_topology_and_every_point) {
  for (const Known& known : {Known{"bunny", 0}, Known{"igea", 0}, Known{"anchor", 4}}) {
    const std::vector<Point3> points = shared_points(known.name);
    if (points.empty()) GTEST_SKIP() << known.name << " is not there";
    for (const std::size_t part : {4U, 10U, 30U}) {
      for (const std::uint32_t seed : {1U, 2U}) {
        const auto s = reconstruct_part(points, part, seed).statistics;
        EXPECT_EQ(s.genus, known.genus) << known.name << " / " << part << ", seed " << seed;
        EXPECT_EQ(s.components, 1U) << known.name << " / " << part << ", seed " << seed;
        EXPECT_LE(s.interior_vertices, 1U) << known.name << " / " << part << ", seed " << seed;
      }
    }
  }
}

/// Down to where the points no longer tell the topology: how often the result is right, and how often
/// topology_uncertain says so. A minute or two; SURFACED_SUBSAMPLES asks for it.
TEST(Subsamples, topology_uncertain_is_several_times_as_frequent_where_the_topology_is_wrong) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody sets it
  if (std::getenv("SURFACED_SUBSAMPLES") == nullptr) GTEST_SKIP() << "takes a minute or two";
  std::size_t right = 0;
  std::size_t right_warned = 0;
  std::size_t wrong = 0;
  std::size_t wrong_warned = 0;
  for (const Known& known :
       {Known{"bunny", 0}, Known{"fandisk", 0}, Known{"anchor", 4}, Known{"fertility", 4}, Known{"knight", 0},
        Known{"elephant", 0}, Known{"max_planck", 0}, Known{"igea", 0}, Known{"octopus", 0}}) {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody sets it
    if (const std::string only = std::getenv("SURFACED_SUBSAMPLES"); only.size() > 1 && only != known.name) continue;
    const std::vector<Point3> points = shared_points(known.name);
    if (points.empty()) GTEST_SKIP() << known.name << " is not there";
    for (const std::size_t part : {2U, 3U, 5U, 7U, 10U, 15U, 20U, 30U, 50U, 70U, 100U, 150U, 200U, 300U}) {
      if (points.size() / part < 40 || points.size() / part > 20000) continue;
      for (const std::uint32_t seed : {1U, 2U, 3U}) {
        const auto result = reconstruct_part(points, part, seed);
        const bool as_known = result.statistics.genus == known.genus && result.statistics.components == 1;
        const bool warned = std::ranges::any_of(
            result.warnings, [](const std::string& w) { return w.starts_with("topology_uncertain"); });
        ++(as_known ? right : wrong);
        if (warned) ++(as_known ? right_warned : wrong_warned);
        const MinimumBoundaryStatistics& s = result.statistics;
        std::cout << (as_known ? "right " : "wrong ") << known.name << " / " << part << ", seed " << seed << ": genus "
                  << s.genus << ", components " << s.components << ", inside " << s.interior_vertices << ", margin "
                  << s.topology_margin.value_or(99) << ", thin " << s.thin_vertices << " of " << points.size() / part
                  << ", buried " << s.buried_vertices << ", ε " << s.sampling->median << ' ' << s.sampling->high << ' '
                  << s.sampling->share_above_one << (result.warnings.empty() ? "" : ", warned") << '\n';
      }
    }
  }
  std::cout << right << " right, " << right_warned << " of them with the warning; " << wrong << " wrong, "
            << wrong_warned << " of them with the warning\n";
  EXPECT_GT(right, 3 * wrong);
  EXPECT_GT(wrong_warned * right, 3 * right_warned * wrong);
}

}  // namespace
}  // namespace surfaced
