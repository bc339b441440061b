// SPDX-License-Identifier: GPL-3.0-or-later
// Upsampling: where new points go, how near they come to the surface, that it ends.
#include "intrinsic_delaunay/upsampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>

#include "intrinsic_delaunay/intrinsic_delaunay.hpp"
#include "intrinsic_delaunay/proposals.hpp"
#include "intrinsic_delaunay/registration.hpp"
#include "intrinsic_delaunay/signature.hpp"
#include "support/shapes.hpp"
#include "support/tri_torus.hpp"

namespace surfaced::idt {
namespace {

PointCloud cloud_of(std::vector<Point3> points) {
  Result<PointCloud> cloud = make_cloud(testing::raw_cloud(std::move(points)));
  EXPECT_TRUE(cloud.ok());
  return std::move(*cloud);
}

Upsampled upsampled(const PointCloud& cloud, double epsilon, Upsampling way, unsigned threads = 1) {
  Context context(threads);
  const auto reconstruct = [&](const PointCloud& points) -> Result<TriangleMesh> {
    Result<IntrinsicDelaunayResult> result = intrinsic_delaunay(points, {}, context);
    if (!result) return std::move(result).error();
    return std::move(result->mesh);
  };
  Result<TriangleMesh> mesh = reconstruct(cloud);
  EXPECT_TRUE(mesh.ok());
  Result<Upsampled> result = upsample(cloud, std::move(*mesh), epsilon, way, reconstruct, context);
  EXPECT_TRUE(result.ok());
  return std::move(*result);
}

/// The points that the input does not have.
std::vector<Point3> new_points(const PointCloud& before, const PointCloud& after) {
  std::vector<Point3> old = before.positions;
  std::ranges::sort(old);
  std::vector<Point3> added;
  for (const Point3& p : after.positions) {
    if (!std::ranges::binary_search(old, p)) added.push_back(p);
  }
  return added;
}

/// A sphere that is sampled three times as densely below as above.
std::vector<Point3> uneven_sphere() {
  std::vector<Point3> points = testing::sphere_points(1500);
  std::mt19937 random(5);
  std::bernoulli_distribution dropped(0.7);
  std::erase_if(points, [&](const Point3& p) { return p[2] > 0 && dropped(random); });
  return points;
}

TEST(Upsampling, keeps_every_input_point_and_half_epsilon_between_new_points_and_all_others) {
  const PointCloud cloud = cloud_of(uneven_sphere());
  for (const Upsampling way : {Upsampling::jet, Upsampling::paper}) {
    const double epsilon = 0.09;
    const Upsampled result = upsampled(cloud, epsilon, way);
    const std::vector<Point3> added = new_points(cloud, result.cloud);
    EXPECT_EQ(added.size() + cloud.size(), result.cloud.size());
    EXPECT_EQ(added.size(), result.statistics.points_added);
    EXPECT_GT(added.size(), 50U);
    for (const Point3& p : added) {
      for (const Point3& q : result.cloud.positions) EXPECT_TRUE(p == q || norm(p - q) >= epsilon / 2);
    }
  }
}

TEST(Upsampling, leaves_no_triangle_larger_than_epsilon_on_a_sphere) {
  const PointCloud cloud = cloud_of(uneven_sphere());
  const Upsampled result = upsampled(cloud, 0.09, Upsampling::jet);
  EXPECT_EQ(result.statistics.large_triangles, 0U);
  EXPECT_TRUE(topology_of(result.mesh).closed);
}

TEST(Upsampling, ends_within_four_times_the_points_for_any_epsilon) {
  const PointCloud cloud = cloud_of(testing::sphere_points(200));
  for (const double epsilon : {1e-300, 1e-6, 0.01, 0.1, 1.0, 1e9}) {
    const Upsampled result = upsampled(cloud, epsilon, Upsampling::jet);
    EXPECT_LE(result.cloud.size(), 4 * cloud.size()) << epsilon;
    if (epsilon >= 1) {
      EXPECT_EQ(result.cloud.size(), cloud.size());
    }
  }
}

TEST(Upsampling, is_the_same_for_any_order_and_threads) {
  std::vector<Point3> points = uneven_sphere();
  const Upsampled first = upsampled(cloud_of(points), 0.09, Upsampling::paper);
  std::ranges::shuffle(points, std::mt19937(2));
  const Upsampled second = upsampled(cloud_of(points), 0.09, Upsampling::paper, 2);
  EXPECT_EQ(first.cloud.positions, second.cloud.positions);
  EXPECT_EQ(first.mesh.triangles, second.mesh.triangles);
}

struct Accuracy {
  std::size_t points = 0;
  std::size_t from_patches = 0;
  /// Mean distance of the new points to the true surface, in ε.
  double mean = 0;
};

template <class Distance>
Accuracy accuracy(const PointCloud& cloud, double epsilon, Upsampling way, const Distance& distance) {
  const Upsampled result = upsampled(cloud, epsilon, way);
  const std::vector<Point3> added = new_points(cloud, result.cloud);
  Accuracy a{added.size(), result.statistics.from_patches, 0};
  for (const Point3& p : added) a.mean += distance(p) / (epsilon * static_cast<double>(added.size()));
  return a;
}

/// Mean distance of the paper's Gaussian means over the centres of triangles, in ε.
template <class Distance>
double accuracy_of_means(const PointCloud& cloud, double epsilon, const Distance& distance) {
  Context context;
  const auto mesh = intrinsic_delaunay(cloud, {}, context);
  const std::vector<Point3> normals(cloud.size(), Point3{});
  const Surroundings surroundings(cloud.positions, normals, epsilon);
  double sum = 0;
  for (const Triangle& t : mesh->mesh.triangles) {
    Point3 centre{};
    for (const VertexIndex v : t) {
      for (std::size_t k = 0; k < 3; ++k) centre[k] += cloud.positions[v][k] / 3;
    }
    sum += distance(surroundings.gaussian_mean(centre));
  }
  return sum / (epsilon * static_cast<double>(mesh->mesh.triangles.size()));
}

TEST(Upsampling, puts_new_points_near_the_true_surface_and_nearer_by_jets_than_by_means_or_patches) {
  const auto on_sphere = [](const Point3& p) { return std::abs(norm(p) - 1); };
  const auto on_torus = [](const Point3& p) { return std::abs(std::hypot(std::hypot(p[0], p[1]) - 1, p[2]) - 0.3); };
  std::vector<Point3> torus = testing::torus_points(120, 40);
  std::mt19937 random(1);
  std::bernoulli_distribution dropped(0.4);
  std::erase_if(torus, [&](const Point3&) { return dropped(random); });
  const auto compare = [&](const std::string& name, const PointCloud& cloud, double epsilon, const auto& distance) {
    const Accuracy jet = accuracy(cloud, epsilon, Upsampling::jet, distance);
    const Accuracy paper = accuracy(cloud, epsilon, Upsampling::paper, distance);
    const double mean = accuracy_of_means(cloud, epsilon, distance);
    const auto text = [](const Accuracy& a) {
      return std::to_string(a.points) + " points, " + std::to_string(a.from_patches) + " from patches, mean distance " +
             std::to_string(a.mean) + " epsilon";
    };
    ::testing::Test::RecordProperty(name + "_jet", text(jet));
    ::testing::Test::RecordProperty(name + "_paper", text(paper));
    ::testing::Test::RecordProperty(name + "_mean", std::to_string(mean));
    EXPECT_GT(jet.points, 20U) << name;
    EXPECT_GT(paper.from_patches, 0U) << name;
    EXPECT_LT(jet.mean, 0.02) << name;
    EXPECT_LT(paper.mean, 0.25) << name;
    EXPECT_LT(jet.mean, paper.mean) << name;
    EXPECT_LT(3 * jet.mean, mean) << name;
  };
  compare("sphere", cloud_of(uneven_sphere()), 0.09, on_sphere);
  compare("torus", cloud_of(std::move(torus)), 0.045, on_torus);
  compare("tri_torus", cloud_of(testing::tri_torus_points(6401, 0.045, 1)), 0.06, testing::distance_to_tri_torus);
}

TEST(Upsampling, stops_when_cancelled) {
  const PointCloud cloud = cloud_of(uneven_sphere());
  std::atomic<bool> cancel = false;
  Context context(1, {}, &cancel);
  Result<IntrinsicDelaunayResult> mesh = intrinsic_delaunay(cloud, {}, context);
  ASSERT_TRUE(mesh.ok());
  cancel = true;
  const auto result = upsample(
      cloud, mesh->mesh, 0.05, Upsampling::jet,
      [](const PointCloud&) -> Result<TriangleMesh> { return TriangleMesh{}; }, context);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::cancelled);
}

TEST(Similarity, is_one_for_equal_signatures_only_and_at_least_minus_a_third) {
  std::mt19937 random(1);
  std::normal_distribution<double> value;
  for (int round = 0; round < 2000; ++round) {
    Signature f{};
    Signature g{};
    for (double& x : f) x = value(random);
    for (double& x : g) x = value(random);
    if (round % 3 == 0) std::ranges::transform(f, g.begin(), [](double x) { return -x; });
    EXPECT_DOUBLE_EQ(similarity(f, f), 1);
    EXPECT_LT(similarity(f, g), 1);
    EXPECT_GE(similarity(f, g), -1.0 / 3 - 1e-15);
    EXPECT_DOUBLE_EQ(similarity(f, g), similarity(g, f));
  }
  EXPECT_EQ(similarity({}, {}), 1);
  EXPECT_EQ(similarity({}, {1}), 0);
}

TEST(Signature, is_the_same_at_any_scale) {
  const std::vector<LocalShape::Curvature> small{{-2, 4}, {0, 0}, {1, -3}};
  std::vector<LocalShape::Curvature> large;
  for (const auto& c : small) large.push_back({c.mean / 8, c.gaussian / 64});
  EXPECT_EQ(signature_of(small, 0.5), signature_of(large, 4));
  const Signature flat = signature_of(std::vector<LocalShape::Curvature>{{0, 0}, {0, 0}}, 1);
  EXPECT_EQ(flat, Signature{});
}

TEST(LocalShape, gives_a_sphere_its_curvature) {
  const std::vector<Point3> points = testing::sphere_points(20000, {0, 0, 0}, 2);
  std::vector<Point3> near;
  for (const Point3& p : points) {
    if (norm(p - Point3{0, 0, 2}) < 0.1) near.push_back(p);
  }
  const auto shape = fit_shape(near, {0, 0, 2.01}, {0, 0, 1});
  ASSERT_TRUE(shape);
  EXPECT_NEAR(norm(shape->above({0.02, 0.01, 2.3})), 2, 1e-5);
  EXPECT_NEAR(shape->curvature_at({0, 0, 2}).mean, -0.5, 1e-3);
  EXPECT_NEAR(shape->curvature_at({0, 0, 2}).gaussian, 0.25, 1e-3);
  EXPECT_FALSE(fit_shape(std::vector<Point3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {0, 0, 0}, {0, 0, 1}));
}

TEST(Align, finds_a_moved_patch_again) {
  std::vector<Point3> patch;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) patch.push_back({0.3 * i, 0.2 * j, 0.05 * i * i - 0.03 * i * j});
  }
  std::vector<Point3> moved;
  for (const Point3& p : patch) {
    const double c = std::cos(2.0);
    const double s = std::sin(2.0);
    moved.push_back({c * p[0] - s * p[1] + 5, s * p[0] + c * p[1] - 3, p[2] + 1});
  }
  const auto target_shape = fit_shape(patch, patch[5], {0, 0, 1});
  const auto shape = fit_shape(moved, moved[5], {0, 0, 1});
  ASSERT_TRUE(target_shape && shape);
  const auto aligned = align(patch, *target_shape, moved, *shape);
  ASSERT_TRUE(aligned);
  EXPECT_LT(aligned->rms, 1e-9);
  EXPECT_FALSE(align({}, *target_shape, moved, *shape));
}

}  // namespace
}  // namespace surfaced::idt
