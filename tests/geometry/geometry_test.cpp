// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds at which geometry code crashes or has no end, through the methods and stages that have to stand them.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <algorithm>
#include <limits>

#include "geometry/geometry_case.hpp"
#include "geometry/shapes.hpp"
#include "support/limited_child.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using testing::GeometryCase;
using testing::Numbers;
using testing::shapes::Points;

double seconds_so_far() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return testing::processor_seconds(usage);
}

class GeometryTest : public ::testing::Test {
 protected:
  /// The name of the error, or "done"; aborts where the case breaks what must hold of every one.
  std::string outcome(Points points, const std::string& method, const Json& given) {
    GeometryCase geometry;
    geometry.cloud.positions = std::move(points);
    geometry.method = *find_method(method);
    geometry.parameters = *check_parameters(*geometry.method, given);
    geometry.extension = ".glb";
    return run(geometry);
  }
  std::string run(const GeometryCase& geometry) {
    const double before = seconds_so_far();
    std::string name = run_case(geometry, folder_.path());
    if (!testing::measuring_is_moot()) {
      EXPECT_LT(seconds_so_far() - before, most_cost(*geometry.method, geometry.cloud.size()).seconds)
          << geometry.text();
    }
    return name;
  }

 private:
  testing::TemporaryDirectory folder_;
};

/// All methods with a parameter each.
std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const MethodInfo& method : methods()) names.push_back(method.id);
  return names;
}

/// k points around (1, 1, 1) that differ by last bits.
Points coincident(std::size_t k) {
  Points points;
  Point3 p{1, 1, 1};
  for (std::size_t i = 0; i < k; ++i) {
    points.push_back(p);
    p.at(i % 3) = std::nextafter(p.at(i % 3), 2.0);
  }
  return points;
}

Points joined(Points points, const Points& more) {
  points.insert(points.end(), more.begin(), more.end());
  return points;
}

TEST_F(GeometryTest, a_sphere_of_latitudes_whose_poles_are_a_hundred_points_is_reconstructed_by_poisson) {
  Points points;
  constexpr std::size_t kRings = 100;
  for (std::size_t i = 0; i < kRings; ++i) {
    for (std::size_t j = 0; j < kRings; ++j) {
      const double theta = std::numbers::pi * static_cast<double>(i) / (kRings - 1);
      const double phi = 2 * std::numbers::pi * static_cast<double>(j) / kRings;
      points.push_back({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
    }
  }
  EXPECT_EQ(outcome(points, "poisson", Json::object()), "done");
}

TEST_F(GeometryTest, points_that_coincide_up_to_roundings_get_normals_and_are_smoothed) {
  Numbers numbers(1);
  const Points sphere = testing::shapes::spiral(60, numbers);
  for (const char* const parameter : {"normals", "smooth"}) {
    for (std::size_t k = 2; k <= 40; ++k) {
      const Json given{{parameter, "jet"}};
      outcome(coincident(k), "advancing-front", given);
      EXPECT_EQ(outcome(joined(sphere, coincident(k)), "local-delaunay", given), "done") << k;
    }
  }
}

TEST_F(GeometryTest, every_method_stands_a_sphere_with_coincident_points_under_all_stages) {
  Numbers numbers(2);
  const Points points = joined(testing::shapes::spiral(80, numbers), coincident(30));
  for (const std::string& method : method_names()) {
    for (const Json& given : {Json{{"normals", "jet"}}, Json{{"smooth", "jet"}}, Json{{"smooth", "bilateral"}},
                              Json{{"normals", "plane"}, {"sample", "hierarchy"}}}) {
      EXPECT_EQ(outcome(points, method, given), "done") << method << " " << given;
    }
  }
}

TEST_F(GeometryTest, extents_that_no_mesh_file_holds_are_refused_by_every_method) {
  for (const double extent : {1e300, 1e-300, 1e-39}) {
    Numbers numbers(3);
    Points points = testing::shapes::uniform(60, numbers);
    for (Point3& p : points) p = extent * p;
    for (const std::string& method : method_names()) {
      EXPECT_EQ(outcome(points, method, Json::object()), "coordinate_out_of_range") << method << " " << extent;
    }
  }
}

TEST_F(GeometryTest, extents_at_the_ends_of_what_a_mesh_file_holds_change_nothing) {
  Numbers numbers(4);
  const Points sphere = testing::shapes::spiral(120, numbers);
  for (const double extent : {0x1p-120, 0x1p-60, 0x1p60, 0x1p120}) {
    Points points = sphere;
    for (Point3& p : points) p = extent * p;
    for (const std::string& method : method_names()) {
      EXPECT_EQ(outcome(points, method, Json::object()), "done") << method << " " << extent;
    }
  }
}

TEST_F(GeometryTest, a_line_of_points_and_one_beside_it_take_no_longer_than_others) {
  for (const std::size_t n : {300U, 1200U}) {
    Points points;
    for (std::size_t i = 0; i < n; ++i) points.push_back({static_cast<double>(i), 0, 0});
    points.push_back({static_cast<double>(n) / 2, static_cast<double>(n) / 3, 1});
    for (const char* const method : {"local-delaunay", "intrinsic-delaunay", "advancing-front"}) {
      outcome(points, method, Json::object());
    }
  }
}

TEST_F(GeometryTest, a_vertex_of_six_thousand_triangles_costs_the_front_no_more_than_a_search_at_each) {
  if (testing::measuring_is_moot()) GTEST_SKIP() << "times mean nothing here";
  constexpr std::size_t kPoints = 6000;
  Numbers numbers(6);
  Points line;
  for (std::size_t i = 0; i < kPoints; ++i) line.push_back({static_cast<double>(i), 0, 0});
  line.push_back({kPoints / 2.0, kPoints / 3.0, 1});
  const auto seconds_of = [&](const Points& points) {
    const double before = seconds_so_far();
    EXPECT_EQ(outcome(points, "local-delaunay", Json::object()), "done");
    return seconds_so_far() - before;
  };
  const double usual = seconds_of(testing::shapes::spiral(kPoints, numbers));
  EXPECT_LT(seconds_of(line), 50 * usual);
}

TEST_F(GeometryTest, points_far_from_all_others_keep_minimum_boundary_below_its_bound) {
  Numbers numbers(7);
  Points points = testing::shapes::spiral(450, numbers);
  for (std::size_t i = 0; i < 150; ++i) points.push_back({static_cast<double>(i), 0, 1e6});
  points.push_back({1e6, 1e-300, 1e-300});
  EXPECT_EQ(outcome(points, "minimum-boundary", Json::object()), "done");
}

TEST_F(GeometryTest, a_lattice_a_billionth_as_large_as_the_cloud_ends_poisson_soon) {
  Numbers numbers(5);
  Points points = testing::shapes::lattice(40, numbers);
  for (Point3& p : points) p = 1e-9 * p + Point3{1, 0, 0};
  points = joined(std::move(points), {{0, -1, 0}, {1e-301, -1, 1e-303}, {0, 1, 0}, {-1, 0, 1e-16}, {0, 0, 1}});
  outcome(points, "poisson", {{"normals", "plane"}, {"sample_share", 0.0010999}});
}

TEST_F(GeometryTest, numbered_cases_that_ended_by_a_signal_once_do_not_any_more) {
  // Cells of points that differ by last bits, which poisson refined.
  for (const std::uint64_t number : {1'000'131U, 2'004'938U}) run(testing::geometry_case(number, 300));
}

TEST_F(GeometryTest, numbered_cases_end_within_their_bound_and_with_an_error_that_helps) {
  constexpr std::uint64_t kCases = 200;
  constexpr std::size_t kMostPoints = 120;
  for (std::uint64_t number = 0; number < kCases; ++number) run(testing::geometry_case(number, kMostPoints));
}

}  // namespace
}  // namespace surfaced
