// SPDX-License-Identifier: GPL-3.0-or-later
// Filling holes: what stays, what is manifold, how near the removed surface the patch comes.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <random>
#include <set>

#include "hole_filling/hole_filling.hpp"
#include "io/io.hpp"
#include "support/holes.hpp"

namespace surfaced {
namespace {

using testing::bumpy_sphere;
using testing::cut_disc;
using testing::manifold_problem;
using testing::triangle;

double diagonal_of(const TriangleMesh& mesh) { return bounds_of(mesh.positions).diagonal(); }

FillReport fill(TriangleMesh& mesh, FillParameters parameters = {}) {
  Context context;
  Result<FillReport> report = fill_holes(mesh, parameters, context);
  EXPECT_TRUE(report.ok());
  return report ? *report : FillReport{};
}

/// The surface as it was, but for the triangles that were cut; more vertices and triangles behind it.
void expect_begins_like(const TriangleMesh& filled, const TriangleMesh& before, const FillReport& report) {
  ASSERT_GE(filled.positions.size(), before.positions.size());
  EXPECT_TRUE(std::equal(before.positions.begin(), before.positions.end(), filled.positions.begin()));
  const std::set<Triangle> now(filled.triangles.begin(), filled.triangles.end());
  std::vector<Triangle> kept;
  std::ranges::copy_if(before.triangles, std::back_inserter(kept), [&](const Triangle& t) { return now.contains(t); });
  EXPECT_EQ(kept.size() + report.triangles_cut, before.triangles.size());
  EXPECT_TRUE(std::equal(kept.begin(), kept.end(), filled.triangles.begin()));
}

TEST(FillHoles, closes_a_disc_cut_from_a_bumpy_sphere_near_where_the_surface_was) {
  const TriangleMesh whole = bumpy_sphere(5);
  const double diagonal = diagonal_of(whole);
  for (const double share : {0.025, 0.05, 0.1}) {
    const testing::Cut cut = cut_disc(whole, whole.positions[7], share * diagonal);
    TriangleMesh filled = cut.rest;
    const FillReport report = fill(filled);
    EXPECT_EQ(report.filled, 1U);
    EXPECT_EQ(report.filled_by_library, 0U);
    EXPECT_TRUE(topology_of(filled).closed);
    EXPECT_EQ(manifold_problem(filled), "");
    expect_begins_like(filled, cut.rest, report);
    const double distance =
        testing::mean_distance(filled, cut.rest, whole, whole.positions[7], share * diagonal) / diagonal;
    RecordProperty("mean_distance_" + std::to_string(share), std::to_string(distance));
    EXPECT_LE(distance, 0.003) << "radius " << share;
  }
}

TEST(FillHoles, comes_nearer_to_a_sphere_when_triangles_are_turned_to_harmonic_normals) {
  const TriangleMesh whole = bumpy_sphere(5, 0);
  const testing::Cut cut = cut_disc(whole, whole.positions[7], 0.3);
  std::map<Rotation, double> distance;
  for (const Rotation rotation : {Rotation::normal, Rotation::none, Rotation::paper}) {
    TriangleMesh filled = cut.rest;
    EXPECT_EQ(fill(filled, {.holes = FillParameters::Holes::all, .rotation = rotation}).filled, 1U);
    EXPECT_EQ(manifold_problem(filled), "");
    const std::size_t first = whole.positions.size();
    const auto added = static_cast<double>(filled.positions.size() - first);
    for (std::size_t v = first; v < filled.positions.size(); ++v) {
      distance[rotation] += std::abs(norm(filled.positions[v]) - 1) / added;
    }
  }
  RecordProperty("normal", std::to_string(distance[Rotation::normal]));
  RecordProperty("none", std::to_string(distance[Rotation::none]));
  RecordProperty("paper", std::to_string(distance[Rotation::paper]));
  EXPECT_LT(10 * distance[Rotation::normal], distance[Rotation::none]);
}

TEST(FillHoles, leaves_a_mesh_without_holes_alone) {
  TriangleMesh mesh = bumpy_sphere(2);
  const FillReport report = fill(mesh);
  EXPECT_EQ(report.loops, 0U);
  EXPECT_EQ(mesh.positions.size(), bumpy_sphere(2).positions.size());
}

TEST(FillHoles, fills_small_holes_without_new_vertices_and_leaves_longer_ones) {
  const TriangleMesh whole = bumpy_sphere(4);
  TriangleMesh mesh = cut_disc(whole, whole.positions[0], 0.1).rest;
  mesh = cut_disc(mesh, whole.positions[3], 0.5).rest;
  const std::size_t vertices = mesh.positions.size();
  const FillReport report = fill(mesh, {.holes = FillParameters::Holes::small, .rotation = Rotation::normal});
  EXPECT_EQ(report.loops, 2U);
  EXPECT_EQ(report.filled, 1U);
  ASSERT_EQ(report.left.size(), 1U);
  EXPECT_NE(report.left[0].reason.find("longer than the 30 edges"), std::string::npos);
  EXPECT_EQ(mesh.positions.size(), vertices);
  EXPECT_EQ(manifold_problem(mesh), "");
}

TEST(FillHoles, closes_the_ends_of_a_tube_though_the_surface_leads_away_from_them) {
  TriangleMesh tube = testing::torus_mesh(48, 16);
  tube = cut_disc(tube, {1, 0, 0}, 0.5).rest;
  const FillReport report = fill(tube);
  EXPECT_EQ(report.loops, 2U);
  EXPECT_EQ(report.filled, 2U);
  EXPECT_EQ(manifold_problem(tube), "");
  EXPECT_TRUE(topology_of(tube).closed);
  EXPECT_EQ(topology_of(tube).genus, 0);
}

TEST(FillHoles, leaves_the_outer_rim_of_a_sheet_and_says_that_it_is_too_large) {
  const TriangleMesh whole = bumpy_sphere(4);
  TriangleMesh sheet = cut_disc(whole, whole.positions[0], 0.5).removed;
  sheet = cut_disc(sheet, whole.positions[0], 0.15).rest;
  const FillReport report = fill(sheet);
  EXPECT_EQ(report.loops, 2U);
  EXPECT_EQ(report.filled, 1U);
  ASSERT_EQ(report.left.size(), 1U);
  EXPECT_NE(report.left[0].reason.find("half of its component's"), std::string::npos) << report.left[0].reason;
  EXPECT_EQ(manifold_problem(sheet), "");
}

TEST(FillHoles, leaves_single_triangles_and_ears_as_they_are) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {6, 1, 0}};
  mesh.triangles = {triangle(0, 1, 2), triangle(3, 4, 5), triangle(4, 6, 5)};
  for (const auto holes : {FillParameters::Holes::all, FillParameters::Holes::small}) {
    TriangleMesh filled = mesh;
    const FillReport report = fill(filled, {.holes = holes, .rotation = Rotation::normal});
    EXPECT_EQ(report.left.size(), 2U);
    EXPECT_EQ(manifold_problem(filled), "");
  }
}

TEST(FillHoles, fills_holes_that_touch_in_a_vertex_into_one_umbrella) {
  TriangleMesh mesh = bumpy_sphere(3);
  const VertexIndex v = mesh.triangles[0][0];
  // Two triangles at v that share no edge.
  std::vector<std::size_t> at_v;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (std::ranges::count(mesh.triangles[t], v) > 0) at_v.push_back(t);
  }
  for (const std::size_t t : at_v) {
    const auto common = std::ranges::count_if(
        mesh.triangles[t], [&](VertexIndex u) { return std::ranges::count(mesh.triangles[at_v[0]], u) > 0; });
    if (common != 1) continue;
    mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t));
    break;
  }
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(at_v[0]));
  ASSERT_NE(manifold_problem(mesh), "");
  const FillReport report = fill(mesh);
  EXPECT_EQ(report.filled, 2U);
  EXPECT_EQ(manifold_problem(mesh), "");
  EXPECT_TRUE(topology_of(mesh).closed);
}

TEST(FillHoles, leaves_loops_of_two_sheets_that_touch_in_a_vertex_and_names_it) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}};
  for (int i = 0; i < 6; ++i) {
    const double a = i * std::numbers::pi / 3;
    for (const double z : {1.0, -1.0}) mesh.positions.push_back({std::cos(a), std::sin(a), z});
  }
  // Two halves of cones, tip to tip: each tip lies on the rim.
  for (std::size_t i = 0; i < 4; ++i) {
    mesh.triangles.push_back(triangle(0, 1 + 2 * i, 3 + 2 * i));
    mesh.triangles.push_back(triangle(0, 4 + 2 * i, 2 + 2 * i));
  }
  const std::size_t triangles = mesh.triangles.size();
  const FillReport report = fill(mesh);
  EXPECT_EQ(report.filled, 0U);
  ASSERT_EQ(report.left.size(), 2U);
  for (const LoopLeft& left : report.left)
    EXPECT_NE(left.reason.find("in (0, 0, 0)"), std::string::npos) << left.reason;
  EXPECT_EQ(mesh.triangles.size(), triangles);
}

TEST(FillHoles, gives_new_vertices_the_normals_and_colours_of_the_rim) {
  TriangleMesh mesh = cut_disc(bumpy_sphere(4, 0), {0, 0, 1}, 0.4).rest;
  for (const Point3& p : mesh.positions) {
    mesh.normals.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    mesh.colors.push_back({static_cast<std::uint8_t>(p[0] > 0 ? 200 : 100), 50, 0, 255});
  }
  const std::size_t before = mesh.positions.size();
  fill(mesh);
  ASSERT_GT(mesh.positions.size(), before);
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
  for (std::size_t v = before; v < mesh.positions.size(); ++v) {
    const Normal3& n = mesh.normals[v];
    const Point3 normal{n[0], n[1], n[2]};
    EXPECT_NEAR(norm(normal), 1, 1e-6);
    EXPECT_GT(dot(normal, mesh.positions[v]), 0.99 * norm(mesh.positions[v]));
    EXPECT_GE(mesh.colors[v][0], 100);
    EXPECT_LE(mesh.colors[v][0], 200);
    EXPECT_EQ(mesh.colors[v][1], 50);
    EXPECT_EQ(mesh.colors[v][3], 255);
  }
}

TEST(FillHoles, keeps_every_mesh_manifold_whatever_triangles_are_missing) {
  std::mt19937 random(7);
  std::size_t filled = 0;
  std::size_t loops = 0;
  for (int round = 0; round < 60; ++round) {
    TriangleMesh mesh = round % 2 == 0 ? bumpy_sphere(3, 0.3) : testing::torus_mesh(24, 9);
    const double share = 0.02 * (1 + round % 20);
    std::bernoulli_distribution missing(share);
    std::erase_if(mesh.triangles, [&](const Triangle&) { return missing(random); });
    const Topology before = topology_of(mesh);
    for (const auto holes : {FillParameters::Holes::all, FillParameters::Holes::small}) {
      TriangleMesh result = mesh;
      const FillReport report = fill(result, {.holes = holes, .rotation = Rotation::normal});
      expect_begins_like(result, mesh, report);
      const Topology after = topology_of(result);
      EXPECT_TRUE(after.edge_manifold);
      EXPECT_TRUE(after.oriented);
      EXPECT_LE(after.non_manifold_vertices, before.non_manifold_vertices);
      if (after.closed && after.vertex_manifold) {
        EXPECT_EQ(manifold_problem(result), "");
      }
      EXPECT_EQ(report.filled + report.left.size(), report.loops);
      for (const Point3& p : result.positions) EXPECT_TRUE(std::isfinite(p[0] + p[1] + p[2]));
      filled += report.filled;
      loops += report.loops;
    }
  }
  RecordProperty("filled", static_cast<int>(filled));
  RecordProperty("loops", static_cast<int>(loops));
}

TEST(FillHoles, survives_coincident_and_collinear_rims) {
  TriangleMesh mesh = cut_disc(bumpy_sphere(3, 0), {0, 0, 1}, 0.5).rest;
  for (Point3& p : mesh.positions) p = {p[0], 0, 0};
  fill(mesh);
  EXPECT_TRUE(topology_of(mesh).edge_manifold);
  for (Point3& p : mesh.positions) p = {1e300, 1e300, 1e-300};
  fill(mesh);
  EXPECT_TRUE(topology_of(mesh).edge_manifold);
}

TEST(FillHoles, stops_when_cancelled) {
  const std::atomic<bool> cancel = true;
  Context context(1, {}, &cancel);
  TriangleMesh mesh = cut_disc(bumpy_sphere(3), {0, 0, 1}, 0.5).rest;
  const auto report = fill_holes(mesh, {}, context);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::cancelled);
}

/// Mean distance of the removed vertices that are not on the rim to the quadric that fits all removed vertices best.
double distance_to_best_quadric(const testing::Cut& cut) {
  std::set<std::size_t> removed;
  std::set<std::size_t> rest;
  for (const Triangle& t : cut.removed.triangles) removed.insert(t.begin(), t.end());
  for (const Triangle& t : cut.rest.triangles) rest.insert(t.begin(), t.end());
  Eigen::MatrixX3d points(static_cast<Eigen::Index>(removed.size()), 3);
  for (Eigen::Index row = 0; const std::size_t v : removed) {
    const Point3& p = cut.rest.positions[v];
    points.row(row++) << p[0], p[1], p[2];
  }
  points.rowwise() -= points.colwise().mean().eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(points.transpose() * points);
  const Eigen::MatrixX3d local = points * axes.eigenvectors();  // height, then the plane
  Eigen::MatrixXd terms(points.rows(), 6);
  const auto x = local.col(1).array();
  const auto y = local.col(2).array();
  terms << Eigen::VectorXd::Ones(points.rows()), x, y, x * x, x * y, y * y;
  const Eigen::VectorXd fitted = terms * terms.colPivHouseholderQr().solve(local.col(0));
  double sum = 0;
  std::size_t inside = 0;
  for (Eigen::Index row = 0; const std::size_t v : removed) {
    const double off = std::abs(fitted[row] - local(row, 0));
    ++row;
    if (rest.contains(v)) continue;
    sum += off;
    ++inside;
  }
  return sum / static_cast<double>(inside);
}

/// Discs of this radius (as share of the diagonal) cut from a reference mesh at eight vertices spread over it.
void expect_fills_scan(const std::string& name, double share) {
  const std::filesystem::path file = std::filesystem::path(SURFACED_SHARED_DATA) / "reference" / (name + ".ply");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
  const Result<TriangleMesh> whole = read_mesh(file);
  ASSERT_TRUE(whole.ok());
  const double diagonal = diagonal_of(*whole);
  for (std::size_t k = 1; k <= 8; ++k) {
    const Point3 centre = whole->positions[k * whole->positions.size() / 9];
    const testing::Cut cut = cut_disc(*whole, centre, share * diagonal);
    TriangleMesh filled = cut.rest;
    const FillReport report = fill(filled);
    EXPECT_EQ(report.left.size(), 0U);
    EXPECT_TRUE(topology_of(filled).closed);
    EXPECT_TRUE(topology_of(filled).vertex_manifold);
    const double distance = testing::mean_distance(filled, cut.rest, *whole, centre, share * diagonal) / diagonal;
    ::testing::Test::RecordProperty("hole_" + std::to_string(k), std::to_string(distance));
    EXPECT_LE(distance, 0.003) << "hole " << k;
  }
}

TEST(FillHolesOfScans, fills_igea_within_three_thousandths_of_the_diagonal_where_a_twentieth_around_a_point_is_gone) {
  expect_fills_scan("igea", 0.05);
}

TEST(FillHolesOfScans,
     fills_max_planck_within_three_thousandths_of_the_diagonal_where_a_disc_a_twentieth_wide_is_gone) {
  expect_fills_scan("max_planck", 0.025);
}

TEST(FillHolesOfScans, misses_three_thousandths_on_a_disc_twice_as_wide_only_where_the_best_quadric_does_too) {
  const std::filesystem::path file = std::filesystem::path(SURFACED_SHARED_DATA) / "reference" / "max_planck.ply";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
  const Result<TriangleMesh> whole = read_mesh(file);
  ASSERT_TRUE(whole.ok());
  constexpr double kLimit = 0.003;
  const double diagonal = diagonal_of(*whole);
  for (std::size_t k = 1; k <= 8; ++k) {
    const Point3 centre = whole->positions[k * whole->positions.size() / 9];
    const testing::Cut cut = cut_disc(*whole, centre, 0.05 * diagonal);
    TriangleMesh filled = cut.rest;
    const FillReport report = fill(filled);
    if (report.loops != 1) continue;  // the first cuts an ear off
    // The fifth lies at the ear: whatever covers it crosses what is there.
    if (k == 5 && !report.left.empty()) continue;
    ASSERT_TRUE(report.left.empty()) << "hole " << k << ": " << report.left.front().reason;
    EXPECT_TRUE(topology_of(filled).closed);
    const double distance = testing::mean_distance(filled, cut.rest, *whole, centre, 0.05 * diagonal) / diagonal;
    const double best = distance_to_best_quadric(cut) / diagonal;
    RecordProperty("hole_" + std::to_string(k), std::to_string(distance));
    RecordProperty("quadric_" + std::to_string(k), std::to_string(best));
    EXPECT_TRUE(distance <= kLimit || best > kLimit) << "hole " << k << ": " << distance << ", quadric " << best;
  }
}

}  // namespace
}  // namespace surfaced
