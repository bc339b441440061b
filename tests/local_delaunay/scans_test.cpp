// SPDX-License-Identifier: GPL-3.0-or-later
// The clouds of the issue: closed, of the right genus, next to no point unused.
#include <gtest/gtest.h>

#include <string>

#include "local_delaunay/local_delaunay.hpp"
#include "support/scans.hpp"

namespace surfaced {
namespace {

struct Scan {
  const char* name;
  std::int64_t genus;
};

class LocalDelaunayOnScans : public ::testing::TestWithParam<Scan> {};

TEST_P(LocalDelaunayOnScans, closes_with_the_right_genus_and_uses_nearly_all_points) {
  const auto cloud = testing::scan(GetParam().name);
  if (!cloud) GTEST_SKIP() << GetParam().name << " is absent";
  for (const unsigned threads : {1U, 2U}) {
    Context context(threads);
    const auto result = local_delaunay(*cloud, {}, context);
    ASSERT_TRUE(result);
    const Topology topology = topology_of(result->mesh);
    EXPECT_TRUE(topology.closed);
    EXPECT_TRUE(topology.vertex_manifold && topology.oriented);
    EXPECT_EQ(topology.components, 1U);
    EXPECT_EQ(topology.genus, GetParam().genus);
    EXPECT_LE(static_cast<double>(cloud->size() - topology.vertices), 0.001 * static_cast<double>(cloud->size()));
    EXPECT_GT(signed_volume(result->mesh), 0);
  }
}

TEST_P(LocalDelaunayOnScans, stays_closed_with_max_edge_3_but_for_the_openings_of_bunny) {
  const auto cloud = testing::scan(GetParam().name);
  if (!cloud) GTEST_SKIP() << GetParam().name << " is absent";
  Context context;
  const auto result = local_delaunay(*cloud, {.max_edge = 3}, context);
  ASSERT_TRUE(result);
  const Topology topology = topology_of(result->mesh);
  const bool has_openings = std::string(GetParam().name) == "bunny";
  EXPECT_EQ(topology.closed, !has_openings);
  EXPECT_EQ(topology.boundary_loops, has_openings ? 3U : 0U);
  EXPECT_TRUE(topology.vertex_manifold && topology.oriented);  // so every rim passes a vertex once
  EXPECT_EQ(topology.genus, GetParam().genus);
  EXPECT_EQ(topology.components, 1U);
}

INSTANTIATE_TEST_SUITE_P(Scans, LocalDelaunayOnScans,
                         ::testing::Values(Scan{"fertility", 4}, Scan{"igea", 0}, Scan{"anchor", 4},
                                           Scan{"max_planck", 0}, Scan{"elephant", 0}, Scan{"bunny", 0},
                                           Scan{"fandisk", 0}),
                         [](const auto& scan) { return std::string(scan.param.name); });

}  // namespace
}  // namespace surfaced
