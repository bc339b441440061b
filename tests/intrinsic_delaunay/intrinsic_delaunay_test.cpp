// SPDX-License-Identifier: GPL-3.0-or-later
// What intrinsic-delaunay promises: the claims of every front, for all its variants, and its own parameters.
#include "intrinsic_delaunay/intrinsic_delaunay.hpp"

#include <random>

#include "support/front_claims.hpp"

namespace surfaced {
namespace {

using Parameters = IntrinsicDelaunayParameters;

struct IntrinsicDelaunay {
  using Parameters = IntrinsicDelaunayParameters;

  static std::vector<Parameters> variants() {
    return {Parameters{},
            {.epsilon = 0.2},
            {.max_edge = 1.5},
            {.epsilon = 1e-3, .fill_holes = Parameters::FillHoles::none},
            {.max_edge = 1e6}};
  }
  static Parameters scaled(Parameters parameters, double factor) {
    if (parameters.epsilon) *parameters.epsilon *= factor;
    return parameters;
  }
  static std::vector<std::string> stages() {
    return {"neighbourhoods", "consensus", "front", "holes", "flips", "surface"};
  }
  static Result<testing::Grown> run(const PointCloud& cloud, const Parameters& parameters, Context& context) {
    Result<IntrinsicDelaunayResult> result = intrinsic_delaunay(cloud, parameters, context);
    if (!result) return std::move(result).error();
    return testing::Grown{std::move(result->mesh), result->statistics.front.open_edges};
  }
};

Result<IntrinsicDelaunayResult> reconstruct(const std::vector<Point3>& points, const Parameters& parameters) {
  Context context;
  return intrinsic_delaunay(*make_cloud(testing::raw_cloud(points)), parameters, context);
}

TEST(IntrinsicDelaunayVariants, few_faces_are_dropped_where_noise_folds_the_surface_over) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> jitter(-0.3, 0.3);
    std::normal_distribution<double> noise(0, 1);
    std::vector<Point3> sheet;
    for (int i = 0; i < 80; ++i) {
      for (int j = 0; j < 80; ++j) {
        const double x = i + jitter(random);
        const double y = j + jitter(random);
        sheet.push_back({x, y, noise(random)});
      }
    }
    const auto result = reconstruct(sheet, {});
    ASSERT_TRUE(result);
    testing::expect_oriented_manifold(result->mesh, "noisy sheet");
    const auto& front = result->statistics.front;
    EXPECT_LT(front.one_sided_faces, 0.015 * static_cast<double>(front.agreed_faces)) << seed;
  }
}

TEST(IntrinsicDelaunayVariants, epsilon_bounds_how_far_a_face_reaches_from_the_edge_it_was_made_at) {
  const auto points = testing::random_torus(4000, 6);
  constexpr double kEpsilon = 0.02;
  const auto result = reconstruct(points, {.epsilon = kEpsilon, .fill_holes = Parameters::FillHoles::none});
  ASSERT_TRUE(result);
  testing::expect_oriented_manifold(result->mesh, "small epsilon");
  EXPECT_GT(result->statistics.front.open_edges, 0U);
  // The height over the longest edge is the least distance of a vertex from the opposite edge. Flips and points
  // inserted later keep within what was there.
  std::size_t higher = 0;
  for (const Triangle& t : result->mesh.triangles) {
    const Point3& a = result->mesh.positions[t[0]];
    const Point3 n = cross(result->mesh.positions[t[1]] - a, result->mesh.positions[t[2]] - a);
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(longest, norm(result->mesh.positions[t[(i + 1) % 3]] - result->mesh.positions[t[i]]));
    if (norm(n) / longest > 2 * kEpsilon) ++higher;
  }
  EXPECT_EQ(higher, 0U);
}

TEST(IntrinsicDelaunayVariants, max_edge_bounds_every_edge) {
  auto points = testing::sphere_points(4000);
  std::erase_if(points, [](const Point3& p) { return p[2] > 0.96; });
  for (const std::optional<double> limit : {std::optional<double>(), std::optional<double>(2.5)}) {
    const auto result = reconstruct(points, {.max_edge = limit});
    ASSERT_TRUE(result);
    const Topology topology = topology_of(result->mesh);
    EXPECT_EQ(topology.boundary_loops, 1U) << "the opening stays open";
    EXPECT_EQ(topology.vertices, points.size());
  }
}

TEST(IntrinsicDelaunayVariants, a_plane_has_no_curvature_and_so_no_largest_epsilon) {
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

namespace testing {
INSTANTIATE_TYPED_TEST_SUITE_P(IntrinsicDelaunay, FrontClaims, IntrinsicDelaunay);
}  // namespace testing
}  // namespace surfaced
