// SPDX-License-Identifier: GPL-3.0-or-later
// The clouds of the issue: closed where the reference is, of the right genus, next to no point unused, and triangles as
// good as those of CGAL's advancing front.
#include <gtest/gtest.h>

#include <string>

#include "baselines/baselines.hpp"
#include "intrinsic_delaunay/intrinsic_delaunay.hpp"
#include "quality/quality.hpp"
#include "support/scans.hpp"

namespace surfaced {
namespace {

struct Scan {
  const char* name;
  bool closed;
  std::int64_t genus;
};

Distribution inradius_to_longest_edge(const TriangleMesh& mesh) {
  return *measure_quality(mesh, topology_of(mesh)).inradius_to_longest_edge;
}

class IntrinsicDelaunayOnScans : public ::testing::TestWithParam<Scan> {};

TEST_P(IntrinsicDelaunayOnScans, closes_where_the_reference_does_and_shapes_triangles_as_well_as_cgal) {
  const auto cloud = testing::scan(GetParam().name);
  if (!cloud) GTEST_SKIP() << GetParam().name << " is absent";
  Context context(2);
  const auto result = intrinsic_delaunay(*cloud, {}, context);
  ASSERT_TRUE(result);
  const Topology topology = topology_of(result->mesh);
  EXPECT_TRUE(topology.edge_manifold && topology.vertex_manifold && topology.oriented);
  EXPECT_TRUE(topology.closed || !GetParam().closed);
  EXPECT_EQ(topology.components, 1U);
  EXPECT_EQ(topology.genus, GetParam().genus);
  EXPECT_LE(static_cast<double>(cloud->size() - topology.vertices), 0.001 * static_cast<double>(cloud->size()));

  const auto peer = advancing_front(*cloud, {}, context);
  ASSERT_TRUE(peer);
  const Distribution ours = inradius_to_longest_edge(result->mesh);
  const Distribution theirs = inradius_to_longest_edge(*peer);
  EXPECT_GE(ours.mean, 0.995 * theirs.mean);
  EXPECT_GE(ours.p05, theirs.p05);
  RecordProperty("p05", std::to_string(ours.p05) + " against " + std::to_string(theirs.p05));
  RecordProperty("mean", std::to_string(ours.mean) + " against " + std::to_string(theirs.mean));
}

INSTANTIATE_TEST_SUITE_P(Scans, IntrinsicDelaunayOnScans,
                         ::testing::Values(Scan{"fertility", true, 4}, Scan{"igea", true, 0}, Scan{"anchor", true, 4},
                                           Scan{"max_planck", true, 0}, Scan{"elephant", true, 0},
                                           Scan{"bunny", false, 0}),
                         [](const auto& scan) { return std::string(scan.param.name); });

TEST(IntrinsicDelaunayOnOpenScans, the_opening_of_the_face_stays_open) {
  const auto cloud = testing::scan("face");
  if (!cloud) GTEST_SKIP() << "face is absent";
  Context context(2);
  const auto result = intrinsic_delaunay(*cloud, {}, context);
  ASSERT_TRUE(result);
  const Topology topology = topology_of(result->mesh);
  EXPECT_EQ(topology.boundary_loops, 1U);
  EXPECT_EQ(topology.boundary_edges, 96U);
}

}  // namespace
}  // namespace surfaced
