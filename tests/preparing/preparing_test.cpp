// SPDX-License-Identifier: GPL-3.0-or-later
#include "preparing/preparing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <random>

#include "support/nasty_clouds.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

PointCloud cloud_of(std::vector<Point3> points) { return *make_cloud(testing::raw_cloud(std::move(points))); }

using Stage = std::function<Result<PointCloud>(const PointCloud&, Context&)>;
struct Named {
  const char* name;
  Stage run;
};
const std::vector<Named>& stages() {
  static const std::vector<Named> all{
      {"outliers", [](const PointCloud& c, Context& x) { return without_outliers(c, 3, x); }},
      {"fuse", [](const PointCloud& c, Context& x) { return fused(c, 0.1, x); }},
      {"grid", [](const PointCloud& c, Context& x) { return sampled(c, std::nullopt, x); }},
      {"hierarchy", [](const PointCloud& c, Context& x) { return clustered(c, 0.25, x); }},
      {"wlop", [](const PointCloud& c, Context& x) { return consolidated(c, 0.25, x); }},
      {"jet", [](const PointCloud& c, Context& x) { return smoothed(c, Smoothing::jet, 24, x); }},
      {"bilateral", [](const PointCloud& c, Context& x) { return smoothed(c, Smoothing::bilateral, 24, x); }},
      {"normals", [](const PointCloud& c, Context& x) { return with_normals(c, NormalFit::jet, 18, x); }}};
  return all;
}

double distance_to_torus(const Point3& p) { return std::abs(std::hypot(std::hypot(p[0], p[1]) - 1, p[2]) - 0.3); }

double mean_distance(const PointCloud& cloud) {
  double sum = 0;
  for (const Point3& p : cloud.positions) sum += distance_to_torus(p);
  return sum / static_cast<double>(cloud.size());
}

TEST(Preparing, smoothing_and_wlop_bring_noisy_points_nearer_to_the_truth) {
  const PointCloud noisy = cloud_of(testing::random_torus(4000, 7, 0.02));
  Context context;
  const double before = mean_distance(noisy);
  EXPECT_LT(mean_distance(*smoothed(noisy, Smoothing::jet, 48, context)), 0.6 * before);
  EXPECT_LT(mean_distance(*smoothed(noisy, Smoothing::bilateral, 48, context)), 0.7 * before);
  EXPECT_LT(mean_distance(*consolidated(noisy, 0.25, context)), before);
}

TEST(Preparing, samples_keep_about_the_share_asked_for_and_input_points_but_for_wlop) {
  const PointCloud cloud = cloud_of(testing::random_torus(4000, 7));
  Context context;
  const PointCloud sample = *clustered(cloud, 0.25, context);
  EXPECT_GT(sample.size(), 1000U);
  EXPECT_LT(sample.size(), 2400U);
  for (const double d : nearest_points(cloud.positions, sample.positions, 1).distance) EXPECT_EQ(d, 0);
  EXPECT_EQ(consolidated(cloud, 0.25, context)->size(), 1000U);
}

TEST(Preparing, normals_of_closed_surfaces_face_outwards_in_every_part) {
  std::vector<Point3> points = testing::sphere_points(2000);
  for (const Point3& p : testing::sphere_points(500, {5, 0, 0}, 0.5)) points.push_back(p);
  const PointCloud cloud = cloud_of(points);
  for (const NormalFit fit : {NormalFit::plane, NormalFit::jet}) {
    Context context;
    const auto with = with_normals(cloud, fit, 18, context);
    ASSERT_TRUE(with) << with.error().detail;
    for (std::size_t v = 0; v < with->size(); ++v) {
      const Point3 centre{cloud.positions[v][0] > 3 ? 5.0 : 0.0, 0, 0};
      const Point3 out = cloud.positions[v] - centre;
      const Normal3& n = with->normals[v];
      const Point3 normal{static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])};
      EXPECT_GT(dot(out, normal) / norm(out), 0.97);
    }
  }
}

TEST(Preparing, gives_the_same_for_any_order_of_the_points_and_number_of_threads) {
  std::vector<Point3> points = testing::random_torus(5000, 3, 0.01);
  const PointCloud first = cloud_of(points);
  std::ranges::shuffle(points, std::mt19937(1));
  const PointCloud second = cloud_of(points);
  for (const auto& [name, run] : stages()) {
    Context one(1);
    Context three(3);
    const auto a = run(first, one);
    const auto b = run(second, three);
    ASSERT_TRUE(a && b) << name;
    EXPECT_EQ(a->positions, b->positions) << name;
    EXPECT_EQ(a->normals, b->normals) << name;
  }
}

TEST(Preparing, takes_nasty_clouds_and_leaves_finite_points) {
  for (std::uint64_t number = 0; number < 110; ++number) {
    const testing::NastyCloud nasty = testing::NastyClouds::make(number);
    const PointCloud cloud = cloud_of(nasty.points);
    for (const auto& [name, run] : stages()) {
      Context context;
      const auto result = run(cloud, context);
      if (!result && result.error().code == ErrorCode::too_few_points) continue;
      ASSERT_TRUE(result) << name << " of " << nasty.kind << " " << number << ": " << result.error().detail;
      EXPECT_GE(cloud.size(), result->size());
    }
  }
}

/// A torus and k points that differ by a rounding.
PointCloud with_coincident_points(std::size_t k) {
  std::vector<Point3> points = testing::random_torus(60, 5);
  Point3 p{1, 1, 1};
  for (std::size_t i = 0; i < k; ++i) {
    points.push_back(p);
    p.at(i % 3) = std::nextafter(p.at(i % 3), 2.0);
  }
  return cloud_of(points);
}

TEST(Preparing, a_neighbourhood_that_fits_no_quadric_gets_a_unit_normal_and_stays_in_its_place) {
  for (const std::size_t k : {7U, 20U, 40U}) {
    const PointCloud cloud = with_coincident_points(k);
    Context context;
    const auto normals = with_normals(cloud, NormalFit::jet, 6, context);
    ASSERT_TRUE(normals) << normals.error().detail;
    for (const Normal3& n : normals->normals) EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-6) << k;
    const auto smooth = smoothed(cloud, Smoothing::jet, 6, context);
    ASSERT_TRUE(smooth) << smooth.error().detail;
    const auto is_coincident = [](const Point3& p) { return norm(p - Point3{1, 1, 1}) < 1e-14; };
    // Two that a rounding parts may become one.
    EXPECT_GE(std::ranges::count_if(smooth->positions, is_coincident) + 2, static_cast<std::ptrdiff_t>(k));
  }
}

TEST(Preparing, cells_too_small_to_be_numbered_keep_every_point) {
  const PointCloud cloud = cloud_of(testing::random_torus(100, 6));
  for (const double cell : {1e-320, 1e-300, 1e-30}) {
    Context context;
    const auto sample = sampled(cloud, cell, context);
    ASSERT_TRUE(sample) << sample.error().detail;
    EXPECT_EQ(sample->size(), cloud.size()) << cell;
  }
}

TEST(LocalFrame, points_are_the_same_or_a_step_apart) {
  const LocalFrame frame({{0, 0, 0}, {1, 0, 0}, {1e-300, 0, 0}});
  EXPECT_EQ(frame.to_local(Point3{1e-300, 0, 0}), (Point3{0, 0, 0}));
  EXPECT_EQ(frame.to_local(Point3{0x1p-60, 0, 0}), (Point3{0, 0, 0}));
  EXPECT_EQ(frame.to_local(Point3{0x1p-52, 0, 0}), (Point3{0x1p-43, 0, 0}));
  EXPECT_EQ(frame.to_local(Point3{1, 0.1F, 0.3F}), (Point3{512, 512 * 0.1F, 512 * 0.3F}));
}

TEST(Preparing, stops_when_cancelled) {
  const PointCloud cloud = cloud_of(testing::random_torus(2000, 3));
  for (const auto& [name, run] : stages()) {
    const std::atomic<bool> cancel = true;
    Context context(1, {}, &cancel);
    const auto result = run(cloud, context);
    ASSERT_FALSE(result) << name;
    EXPECT_EQ(result.error().code, ErrorCode::cancelled) << name;
  }
}

/// Every point `times` over, each time a little off.
std::vector<Point3> repeated(const std::vector<Point3>& points, int times, double off) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-off, off);
  std::vector<Point3> all;
  for (int k = 0; k < times; ++k) {
    for (const Point3& p : points) all.push_back({p[0] + shift(random), p[1] + shift(random), p[2] + shift(random)});
  }
  return all;
}

TEST(NearRepeats, are_recognised_and_fused_whatever_their_number_and_scale) {
  const std::vector<Point3> points = testing::sphere_points(500);  // about 0.15 apart
  Context context;
  for (const int times : {2, 5, 12, 40}) {
    for (const double off : {1e-9, 1e-6, 0.005}) {
      const PointCloud cloud = cloud_of(repeated(points, times, off));
      const auto repeats = near_repeats_of(cloud.positions);
      ASSERT_TRUE(repeats) << times << " " << off;
      EXPECT_GT(repeats->tolerance, 2 * off);
      EXPECT_LT(repeats->tolerance, 0.1);
      EXPECT_GT(repeats->share, 0.95);
      const PointCloud once = *fused(cloud, repeats->tolerance, context);
      EXPECT_EQ(once.size(), points.size()) << times << " " << off;
      EXPECT_FALSE(near_repeats_of(once.positions));
    }
  }
}

TEST(NearRepeats, are_not_seen_in_grids_scan_lines_random_points_or_bodies_apart) {
  std::vector<Point3> grid;
  std::vector<Point3> lines;
  std::vector<Point3> bodies;
  for (int i = 0; i < 60; ++i) {
    for (int j = 0; j < 60; ++j) {
      grid.push_back({i + 0.0, j + 0.0, 0});
      lines.push_back({i * 10.0, j + 0.0, std::sin(0.1 * j)});
    }
  }
  for (int k = 0; k < 12; ++k) {
    for (const Point3& p : testing::sphere_points(50)) bodies.push_back({p[0] + 100 * k, p[1], p[2]});
  }
  for (const std::vector<Point3>& points :
       {grid, lines, bodies, testing::random_points(5000, 3), testing::random_torus(4000, 7, 0.02),
        testing::sphere_points(300), std::vector<Point3>{{0, 0, 0}, {1, 0, 0}}}) {
    EXPECT_FALSE(near_repeats_of(cloud_of(points).positions)) << points.size();
  }
}

TEST(Fusing, takes_the_mean_weighted_by_how_often_a_point_was_there_and_the_means_of_what_belongs_to_it) {
  RawCloud raw = testing::raw_cloud({{0, 0, 0}, {0, 0, 0}, {0, 0, 0.5}, {9, 9, 9}});
  raw.normals = {{1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  raw.colors = {{90, 0, 0, 255}, {90, 0, 0, 255}, {0, 30, 0, 255}, {1, 2, 3, 4}};
  Context context;
  const PointCloud once = *fused(*make_cloud(raw), 1, context);
  ASSERT_EQ(once.size(), 2U);
  EXPECT_NEAR(once.positions[0][2], 0.5 / 3, 1e-15);
  EXPECT_EQ(once.colors[0], (Color4{60, 10, 0, 255}));
  EXPECT_NEAR(static_cast<double>(once.normals[0][0]), 2 / std::sqrt(5.0), 1e-6);
}

TEST(Fusing, costs_about_as_much_for_any_distance) {
  const PointCloud cloud = cloud_of(testing::random_points(20000, 3));
  Context context;
  for (const double x : {1e-12, 1e-3, 0.1, 10.0, 1e300}) {
    const PointCloud once = *fused(cloud, x, context);
    EXPECT_GE(once.size(), 1U);
    if (x >= 10) {
      EXPECT_EQ(once.size(), 1U);
    }
  }
}

TEST(Sampling, of_points_that_repeat_takes_cells_of_the_size_of_the_spacing_of_what_was_scanned) {
  const std::vector<Point3> points = testing::sphere_points(2000);
  Context context;
  const std::size_t plain = sampled(cloud_of(points), std::nullopt, context)->size();
  const std::size_t repeats = sampled(cloud_of(repeated(points, 5, 1e-6)), std::nullopt, context)->size();
  EXPECT_NEAR(static_cast<double>(repeats), static_cast<double>(plain), 0.05 * static_cast<double>(plain));
}

std::vector<Point3> rounded_to_float(std::vector<Point3> points) {
  for (Point3& p : points) {
    for (double& x : p) x = static_cast<double>(static_cast<float>(x));
  }
  return points;
}

TEST(FloatSteps, are_found_where_coordinates_far_from_the_origin_were_rounded_and_nowhere_else) {
  std::vector<Point3> far = testing::sphere_points(1000);
  for (Point3& p : far) p = {10 * p[0] + 432100, 10 * p[1] + 5431200, 10 * p[2] + 318};
  const auto steps = float_steps_of(rounded_to_float(far), 1);
  ASSERT_TRUE(steps);
  EXPECT_EQ(steps->step, 0.5);
  EXPECT_GT(steps->spacing, 0.3);
  std::vector<Point3> printed = rounded_to_float(far);
  for (Point3& p : printed) {
    for (double& x : p) x = std::round(1000 * x) / 1000;
  }
  EXPECT_TRUE(float_steps_of(printed, 1));
  EXPECT_FALSE(float_steps_of(far, 1));
  EXPECT_FALSE(float_steps_of(rounded_to_float(testing::sphere_points(1000)), 1));
  std::vector<Point3> wide = testing::sphere_points(1000);
  for (Point3& p : wide) p = {1e5 * p[0] + 432100, 1e5 * p[1] + 5431200, 1e5 * p[2] + 318};
  EXPECT_FALSE(float_steps_of(rounded_to_float(wide), 1));
  std::vector<Point3> raster;
  for (int i = 0; i < 1600; ++i) raster.push_back({432100.0 + i % 40, 5431200.0 + i / 40, 0.37 * (i % 7)});
  EXPECT_FALSE(float_steps_of(raster, 1));
}

}  // namespace
}  // namespace surfaced
