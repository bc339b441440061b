// SPDX-License-Identifier: GPL-3.0-or-later
// What local-delaunay promises: the claims of every front, for all its variants, and its own parameters.
#include "local_delaunay/local_delaunay.hpp"

#include "support/front_claims.hpp"

namespace surfaced {
namespace {

using Parameters = LocalDelaunayParameters;

struct LocalDelaunay {
  using Parameters = LocalDelaunayParameters;

  static std::vector<Parameters> variants() {
    return {Parameters{},
            {.star = Parameters::Star::unfolded, .max_edge = 2},
            {.star = Parameters::Star::projected, .angle = Parameters::Angle::projected},
            {.seed = Parameters::Seed::paper},
            {.neighbours = 8, .max_edge = 3},
            {.neighbours = 32, .fill_holes = Parameters::FillHoles::none}};
  }
  static Parameters scaled(const Parameters& parameters, double /*factor*/) { return parameters; }
  static std::vector<std::string> stages() { return {"neighbourhoods", "consensus", "front", "holes", "surface"}; }
  static Result<testing::Grown> run(const PointCloud& cloud, const Parameters& parameters, Context& context) {
    Result<LocalDelaunayResult> result = local_delaunay(cloud, parameters, context);
    if (!result) return std::move(result).error();
    return testing::Grown{std::move(result->mesh), result->statistics.open_edges};
  }
};

Result<LocalDelaunayResult> reconstruct(const std::vector<Point3>& points, const Parameters& parameters) {
  Context context;
  return local_delaunay(*make_cloud(testing::raw_cloud(points)), parameters, context);
}

TEST(LocalDelaunayVariants, all_interpolate_every_point_of_a_sphere) {
  for (const Parameters& parameters : LocalDelaunay::variants()) {
    const auto result = reconstruct(testing::sphere_points(3000), parameters);
    ASSERT_TRUE(result);
    testing::expect_whole_sphere(result->mesh, 3000);
  }
}

TEST(LocalDelaunayVariants, max_edge_keeps_an_opening_open_that_the_front_would_cross) {
  auto points = testing::sphere_points(4000);
  std::erase_if(points, [](const Point3& p) { return p[2] > 0.96; });
  const auto result = reconstruct(points, {.max_edge = 2.5});
  ASSERT_TRUE(result);
  const Topology topology = topology_of(result->mesh);
  EXPECT_EQ(topology.boundary_loops, 1U);
  EXPECT_EQ(topology.vertices, points.size());
  for (const Triangle& t : result->mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      constexpr double kAcross = 0.56;
      EXPECT_LT(norm(result->mesh.positions[t[i]] - result->mesh.positions[t[(i + 1) % 3]]), kAcross / 2);
    }
  }
}

TEST(LocalDelaunayVariants, no_edge_is_longer_than_max_edge_allows) {
  constexpr double kMaxEdge = 2.5;
  std::vector<Point3> points = testing::sphere_points(3000);
  std::erase_if(points, [](const Point3& p) { return p[2] > 0.97 || (p[0] > 0.9 && p[1] > 0); });
  const PointCloud cloud = *make_cloud(testing::raw_cloud(points));
  std::vector<double> spacing;
  for (const Point3& p : cloud.positions) {
    std::vector<double> distances;
    for (const Point3& q : cloud.positions) distances.push_back(norm(q - p));
    std::ranges::nth_element(distances, distances.begin() + 6);  // the first is the point itself
    spacing.push_back(distances[6]);
  }
  Context context;
  const auto result = local_delaunay(cloud, {.max_edge = kMaxEdge}, context);
  ASSERT_TRUE(result);
  EXPECT_GE(topology_of(result->mesh).boundary_loops, 2U);
  constexpr double kRounding = 1 + 1e-6;  // spacings are kept as floats
  for (const Triangle& t : result->mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexIndex a = t[i];
      const VertexIndex b = t[(i + 1) % 3];
      EXPECT_LE(norm(cloud.positions[a] - cloud.positions[b]), kMaxEdge * std::max(spacing[a], spacing[b]) * kRounding);
    }
  }
}

}  // namespace

namespace testing {
INSTANTIATE_TYPED_TEST_SUITE_P(LocalDelaunay, FrontClaims, LocalDelaunay);
}  // namespace testing
}  // namespace surfaced
