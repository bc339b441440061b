// Points in a plane: paper 3's claim that its method then gives the Delaunay triangulation.
#include <gtest/gtest.h>

#include "intrinsic_delaunay/intrinsic_delaunay.hpp"
#include "support/planar_delaunay.hpp"

namespace surfaced {
namespace {

TEST(IntrinsicDelaunayInAPlane, equals_the_two_dimensional_delaunay_triangulation_inside_the_rim) {
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
    const PointCloud cloud = testing::tilted_square(6000, seed);
    Context context;
    const auto result = intrinsic_delaunay(cloud, {}, context);
    ASSERT_TRUE(result);
    EXPECT_EQ(testing::triples_inside(result->mesh), testing::delaunay_triples_inside(cloud));
    const Topology topology = topology_of(result->mesh);
    EXPECT_FALSE(topology.closed);
    EXPECT_EQ(topology.boundary_loops, 1U);
    EXPECT_EQ(topology.components, 1U);
    EXPECT_EQ(topology.vertices, cloud.size());
  }
}

TEST(IntrinsicDelaunayInAPlane, has_no_curvature_and_so_no_largest_epsilon) {
  std::vector<Point3> points;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) points.push_back({1.0 * i, 1.0 * j, 0});
  }
  Context context;
  const auto result = intrinsic_delaunay(*make_cloud(testing::raw_cloud(points)), {}, context);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->mesh.triangles.size(), 2U * 19 * 19);
  const auto certificate = certify(result->mesh, context);
  ASSERT_TRUE(certificate);
  EXPECT_LT(certificate->largest_curvature, 1e-9);
  EXPECT_EQ(certificate->epsilon_within_curvature, Premise::holds);
  EXPECT_EQ(certificate->without_boundary, Premise::fails);
  EXPECT_TRUE(certificate->bounds.met());
}

}  // namespace
}  // namespace surfaced
