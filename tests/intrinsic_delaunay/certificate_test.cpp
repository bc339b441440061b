// SPDX-License-Identifier: GPL-3.0-or-later
#include "intrinsic_delaunay/certificate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>

#include "intrinsic_delaunay/surfaces.hpp"

namespace surfaced {
namespace {

using ::testing::ElementsAre;

Certificate certificate_of(const TriangleMesh& mesh, unsigned threads = 1) {
  Context context(threads);
  auto certificate = certify(mesh, context);
  EXPECT_TRUE(certificate) << certificate.error().detail;
  return std::move(*certificate);
}

TEST(Certificate, of_a_dense_sphere_estimates_the_radii_and_finds_all_else_met) {
  const Certificate c = certificate_of(testing::icosphere(3));
  EXPECT_NEAR(c.largest_curvature, 1, 0.03);
  EXPECT_NEAR(c.curvature_p99, 1, 0.03);
  EXPECT_EQ(c.vertices_without_curvature, 0U);
  EXPECT_LT(c.epsilon, 0.125);
  EXPECT_EQ(c.epsilon_within_curvature, Premise::holds);
  EXPECT_EQ(c.edges_long_enough, Premise::holds);
  EXPECT_EQ(c.without_boundary, Premise::holds);
  EXPECT_EQ(c.injectivity_and_convexity, Premise::estimated);
  EXPECT_NEAR(*c.injectivity_radius, std::numbers::pi, 0.1);
  EXPECT_NEAR(*c.convexity_radius, std::numbers::pi / 2, 0.05);
  EXPECT_EQ(c.premises_met(), Premise::estimated);
  EXPECT_TRUE(c.bounds.met());
  EXPECT_TRUE(c.worst_triangles.empty());
  EXPECT_DOUBLE_EQ(c.hausdorff_bound, 4 * c.largest_curvature * c.epsilon * c.epsilon);
  EXPECT_DOUBLE_EQ(c.normal_bound, 9 * c.largest_curvature * c.epsilon);
}

TEST(Certificate, of_the_paper_s_torus_meets_the_bounds_though_it_breaks_the_premise) {
  const Certificate c = certificate_of(testing::torus_mesh(48, 16));
  // Sixteen points around the tube are few: the quadric overestimates, which errs on the safe side.
  EXPECT_GT(c.largest_curvature, 1 / 0.3);
  EXPECT_LT(c.largest_curvature, 1.3 / 0.3);
  EXPECT_GT(c.epsilon, 0.09);
  EXPECT_LE(*c.largest_epsilon, 0.3 / 8);
  EXPECT_EQ(c.epsilon_within_curvature, Premise::fails);
  EXPECT_EQ(c.premises_met(), Premise::fails);
  EXPECT_TRUE(c.bounds.met());
  EXPECT_TRUE(c.bounds_at_largest_epsilon.met());
}

/// A torus whose tube has the radius r has geodesics around the tube, 2πr long, and conjugate points πr apart.
TEST(Certificate, of_a_torus_finds_the_injectivity_radius_that_its_tube_has) {
  const Certificate c = certificate_of(testing::torus_mesh(400, 120));
  EXPECT_NEAR(*c.injectivity_radius, 0.3 * std::numbers::pi, 0.02);
  EXPECT_EQ(c.injectivity_and_convexity, Premise::estimated);
  // Six points along the torus: further apart than a quarter of the way around its tube.
  const Certificate coarse = certificate_of(testing::torus_mesh(6, 12));
  EXPECT_GT(coarse.epsilon, *coarse.convexity_radius);
  EXPECT_EQ(coarse.injectivity_and_convexity, Premise::fails);
  EXPECT_EQ(certificate_of(testing::tetrahedron()).injectivity_and_convexity, Premise::assumed);
}

TEST(Certificate, at_the_largest_epsilon_has_the_bounds_that_the_paper_prints) {
  const Certificate c = certificate_of(testing::icosphere(1));
  EXPECT_NEAR(c.bounds_at_largest_epsilon.shortest_edge_to_circumradius.lower, 0.5, 0.0005);
  EXPECT_NEAR(c.bounds_at_largest_epsilon.inradius_to_longest_edge.lower, 0.021, 0.0005);
  EXPECT_NEAR(c.bounds_at_largest_epsilon.shortest_edge_to_circumradius.upper, 1.732, 0.0005);
  EXPECT_NEAR(c.bounds_at_largest_epsilon.inradius_to_longest_edge.upper, 0.289, 0.0005);
}

TEST(Certificate, lists_triangles_outside_the_bounds_worst_first_and_counts_no_area_as_outside) {
  TriangleMesh mesh = testing::icosphere(2);
  const std::size_t regular = mesh.triangles.size();
  mesh.positions.insert(mesh.positions.end(), {{3, 0, 0}, {4, 0, 0}, {5, 0, 0}, {4, 0.1, 0}});
  const std::size_t v = mesh.positions.size() - 4;
  mesh.triangles.push_back(testing::triangle(v, v + 2, v + 3));  // a needle
  mesh.triangles.push_back(testing::triangle(v, v + 1, v + 2));  // on a line
  const Certificate c = certificate_of(mesh);
  EXPECT_EQ(c.bounds_at_largest_epsilon.shortest_edge_to_circumradius.violations, 2U);
  EXPECT_EQ(c.bounds.inradius_to_longest_edge.violations, 1U) << "κε is so large that only the line is outside";
  EXPECT_THAT(c.worst_triangles, ElementsAre(TriangleIndex(regular + 1), TriangleIndex(regular)));
  EXPECT_FALSE(c.bounds.met());
}

TEST(Certificate, lists_at_most_a_hundred_triangles) {
  TriangleMesh mesh;
  for (std::size_t i = 0; i < 300; ++i) {
    const auto x = static_cast<double>(i);
    mesh.positions.insert(mesh.positions.end(), {{3 * x, 0, 0}, {3 * x + 1, 0, 0}, {3 * x + 2, 0, 0}});
    mesh.triangles.push_back(testing::triangle(3 * i, 3 * i + 1, 3 * i + 2));
  }
  const Certificate c = certificate_of(mesh);
  EXPECT_EQ(c.bounds.shortest_edge_to_circumradius.violations, 300U);
  EXPECT_EQ(c.worst_triangles.size(), 100U);
  EXPECT_EQ(c.vertices_without_curvature, 900U);
}

TEST(Certificate, names_two_vertices_of_sheets_that_are_too_close) {
  TriangleMesh outer = testing::icosphere(3);
  EXPECT_FALSE(certificate_of(outer).close_sheets);
  TriangleMesh inner = testing::icosphere(3);
  for (Point3& p : inner.positions) {
    for (double& x : p) x *= 0.95;
  }
  for (Triangle& t : inner.triangles) std::swap(t[1], t[2]);
  const Certificate c = certificate_of(testing::together(outer, inner, {0, 0, 0}));
  ASSERT_TRUE(c.close_sheets);
  const auto [a, b] = *c.close_sheets;
  EXPECT_NE(a < outer.positions.size(), b < outer.positions.size());
  EXPECT_EQ(c.injectivity_and_convexity, Premise::fails);
  EXPECT_EQ(c.premises_met(), Premise::fails);
}

/// All pairs within 2 epsilon count, however many neighbours are nearer: a coarse sphere far away sets epsilon.
TEST(Certificate, names_close_sheets_that_are_not_among_the_nearest) {
  const TriangleMesh outer = testing::icosphere(5);
  TriangleMesh far = testing::icosphere(3);
  const double epsilon = certificate_of(far).epsilon * 0.7;
  for (Point3& p : far.positions) {
    for (double& x : p) x *= 0.7;
  }
  for (const double gap : {0.8, 0.95, 1.1}) {
    TriangleMesh inner = outer;
    for (Point3& p : inner.positions) {
      for (double& x : p) x *= 1 - gap * 2 * epsilon;
    }
    for (Triangle& t : inner.triangles) std::swap(t[1], t[2]);
    const TriangleMesh shells = testing::together(outer, inner, {0, 0, 0});
    const Certificate c = certificate_of(testing::together(shells, far, {10, 0, 0}));
    ASSERT_NEAR(c.epsilon, epsilon, 1e-6);
    EXPECT_EQ(c.close_sheets.has_value(), gap < 1) << gap;
  }
}

TEST(Certificate, does_not_take_a_sharp_edge_for_close_sheets) {
  // A wedge whose sides meet at 40 degrees.
  TriangleMesh mesh;
  const double angle = std::numbers::pi / 180 * 20;
  constexpr std::size_t kSide = 12;
  for (std::size_t i = 0; i <= 2 * kSide; ++i) {
    const double s = (static_cast<double>(i) - kSide) / kSide;
    for (std::size_t j = 0; j <= kSide; ++j)
      mesh.positions.push_back({std::abs(s) * std::cos(angle), s * std::sin(angle), static_cast<double>(j) / kSide});
  }
  for (std::size_t i = 0; i < 2 * kSide; ++i) {
    for (std::size_t j = 0; j < kSide; ++j) {
      const std::size_t v = i * (kSide + 1) + j;
      mesh.triangles.push_back(testing::triangle(v, v + kSide + 1, v + 1));
      mesh.triangles.push_back(testing::triangle(v + 1, v + kSide + 1, v + kSide + 2));
    }
  }
  EXPECT_FALSE(certificate_of(mesh).close_sheets);
}

TEST(Certificate, is_the_same_for_split_vertices_threads_and_powers_of_two) {
  const TriangleMesh mesh = testing::torus_mesh(60, 20);
  const Certificate expected = certificate_of(mesh);
  TriangleMesh split;
  for (const Triangle& t : mesh.triangles) {
    const std::size_t v = split.positions.size();
    for (const VertexIndex corner : t) split.positions.push_back(mesh.positions[corner]);
    split.triangles.push_back(testing::triangle(v, v + 1, v + 2));
  }
  EXPECT_EQ(certificate_of(split).largest_curvature, expected.largest_curvature);
  EXPECT_EQ(certificate_of(mesh, 4).largest_curvature, expected.largest_curvature);
  TriangleMesh scaled = mesh;
  for (Point3& p : scaled.positions) {
    for (double& x : p) x *= 0x1p40;
  }
  const Certificate large = certificate_of(scaled);
  EXPECT_NEAR(large.largest_curvature * 0x1p40, expected.largest_curvature, 1e-9);
  EXPECT_EQ(large.epsilon, expected.epsilon * 0x1p40);
  EXPECT_EQ(large.bounds.met(), expected.bounds.met());
}

TEST(Certificate, of_a_vertex_with_a_hundred_thousand_triangles_takes_no_longer_than_of_others) {
  TriangleMesh fan;
  fan.positions.push_back({0, 0, 0});
  constexpr std::size_t kSpokes = 100'000;
  for (std::size_t i = 0; i < kSpokes; ++i) {
    const double a = 2 * std::numbers::pi * static_cast<double>(i) / kSpokes;
    fan.positions.push_back({std::cos(a), std::sin(a), i % 2 == 0 ? 0.5 : -0.5});
    fan.triangles.push_back(testing::triangle(0, 1 + i, 1 + (i + 1) % kSpokes));
  }
  EXPECT_EQ(certificate_of(fan).vertices_without_curvature, 0U);
}

TEST(Certificate, refuses_meshes_without_triangles_and_coordinates_that_are_no_numbers) {
  Context context;
  EXPECT_EQ(certify({}, context).error().code, ErrorCode::method_failed);
  TriangleMesh mesh = testing::tetrahedron();
  mesh.positions[0][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(certify(mesh, context).error().code, ErrorCode::coordinate_not_finite);
  const std::atomic<bool> cancel{true};
  Context stopped(1, {}, &cancel);
  EXPECT_EQ(certify(testing::tetrahedron(), stopped).error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace surfaced
