// SPDX-License-Identifier: GPL-3.0-or-later
// The guarantee, attacked: whatever the input, as long as it is not flat.
#include <gtest/gtest.h>

#include <cstdlib>

#include "minimum_boundary/minimum_boundary.hpp"
#include "support/brute_force_surface.hpp"
#include "support/nasty_clouds.hpp"

namespace surfaced {
namespace {

using Parameters = MinimumBoundaryParameters;

/// How many clouds; more by the environment variable SURFACED_NASTY_CLOUDS.
std::uint64_t cloud_count() {
  const char* text = std::getenv("SURFACED_NASTY_CLOUDS");  // NOLINT(concurrency-mt-unsafe): read once, nobody sets it
  return text != nullptr ? std::strtoull(text, nullptr, 10) : 4000;
}

/// With SURFACED_EVERY_PARAMETER set.
bool every_parameter() {
  return std::getenv("SURFACED_EVERY_PARAMETER") != nullptr;  // NOLINT(concurrency-mt-unsafe): nobody sets it
}

std::vector<Parameters> variants() {
  Parameters fast{.variant = Parameters::Variant::fast};
  Parameters many = fast;
  many.components = Parameters::Components::many;
  Parameters bare = fast;
  bare.lids = Parameters::Lids::none;
  Parameters inflated = fast;
  inflated.stop_after = Parameters::StopAfter::inflated;
  Parameters papers_way{.variant = Parameters::Variant::paper};
  Parameters balls = fast;
  balls.lids = Parameters::Lids::ball;
  Parameters artifacts = fast;
  artifacts.lids = Parameters::Lids::paper;
  Parameters cut = fast;
  cut.lids = Parameters::Lids::mincut;
  Parameters best_many;
  best_many.components = Parameters::Components::many;
  Parameters paper_with_cut = papers_way;
  paper_with_cut.lids = Parameters::Lids::mincut;
  return {Parameters{}, fast, papers_way, balls, cut, bare, many, best_many, artifacts, inflated, paper_with_cut};
}

bool is_flat(ErrorCode code) {
  return code == ErrorCode::too_few_points || code == ErrorCode::collinear || code == ErrorCode::coplanar;
}

/// Reconstructs and checks; false if the cloud is flat.
bool holds(const testing::NastyCloud& nasty, const PointCloud& cloud, const Parameters& parameters) {
  Context context;
  const auto result = minimum_boundary(cloud, parameters, context);
  if (!result) {
    EXPECT_TRUE(is_flat(result.error().code)) << nasty.kind << ": " << result.error().detail;
    return false;
  }
  EXPECT_EQ(testing::surface_problem(result->mesh), "") << nasty.kind;
  EXPECT_EQ(result->statistics.forced_cells, 0U) << nasty.kind;
  return true;
}

TEST(MinimumBoundaryProperty, every_cloud_that_is_not_flat_gives_a_closed_embedded_manifold_around_all_points) {
  const std::uint64_t count = cloud_count();
  const std::vector<Parameters> all = variants();
  std::uint64_t flat = 0;
  for (std::uint64_t number = 0; number < count; ++number) {
    const testing::NastyCloud nasty = testing::NastyClouds::make(number);
    const auto cloud = make_cloud(testing::raw_cloud(nasty.points));
    ASSERT_TRUE(cloud) << nasty.kind << " " << number;
    // In the long run every cloud meets every parameter set, else one of them.
    const std::size_t first = every_parameter() ? 0 : number / 11 % all.size();
    const std::size_t last = every_parameter() ? all.size() : first + 1;
    for (std::size_t k = first; k < last; ++k) {
      if (!holds(nasty, *cloud, all[k])) {
        ++flat;
        break;
      }
      ASSERT_FALSE(HasFailure()) << "cloud " << number << ", parameters " << k;
    }
  }
  EXPECT_LT(flat, count / 10);
  RecordProperty("flat", static_cast<int>(flat));
}

}  // namespace
}  // namespace surfaced
