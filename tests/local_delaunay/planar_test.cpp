// Points in a plane: the method against the 2-D Delaunay triangulation.
#include <gtest/gtest.h>

#include "local_delaunay/local_delaunay.hpp"
#include "support/planar_delaunay.hpp"

namespace surfaced {
namespace {

TEST(LocalDelaunayInAPlane, equals_the_two_dimensional_delaunay_triangulation_inside_the_rim) {
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
    const PointCloud cloud = testing::tilted_square(6000, seed);
    Context context;
    const auto result = local_delaunay(cloud, {}, context);
    ASSERT_TRUE(result);
    EXPECT_EQ(testing::triples_inside(result->mesh), testing::delaunay_triples_inside(cloud));
    const Topology topology = topology_of(result->mesh);
    EXPECT_FALSE(topology.closed);
    EXPECT_EQ(topology.boundary_loops, 1U);
    EXPECT_EQ(topology.components, 1U);
    EXPECT_EQ(topology.vertices, cloud.size());
  }
}

TEST(LocalDelaunayInAPlane, a_grid_gives_a_sheet_with_one_rim) {
  std::vector<Point3> points;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 30; ++j) points.push_back({1.0 * i, 1.0 * j, 5});
  }
  const PointCloud cloud = *make_cloud(testing::raw_cloud(points));
  Context context;
  const auto result = local_delaunay(cloud, {}, context);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->mesh.triangles.size(), 2U * 39 * 29);
  EXPECT_EQ(topology_of(result->mesh).boundary_loops, 1U);
}

}  // namespace
}  // namespace surfaced
