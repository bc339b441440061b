// What is promised of every mesh, by brute force, on random and degenerate clouds.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>

#include "local_delaunay/local_delaunay.hpp"
#include "support/nasty_clouds.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using Parameters = LocalDelaunayParameters;
using Links = std::map<std::size_t, std::map<std::size_t, std::size_t>>;

/// Next vertices on the links of all vertices; empty text unless a directed edge is used twice.
std::string links_of(const TriangleMesh& mesh, Links& links) {
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t a = t[i];
      const std::size_t b = t[(i + 1) % 3];
      const std::size_t c = t[(i + 2) % 3];
      if (a == b || a >= mesh.positions.size()) return "a triangle repeats a vertex or names one that is not there";
      if (!links[a].emplace(b, c).second) return "edge " + std::to_string(a) + "-" + std::to_string(b) + " twice";
    }
  }
  return {};
}

/// Whether the link is one chain or one cycle of at least three edges.
bool is_one_chain(const std::map<std::size_t, std::size_t>& link) {
  std::set<std::size_t> ends;
  for (const auto& [from, to] : link) {
    if (!ends.insert(to).second) return false;
  }
  const auto start = std::ranges::find_if(link, [&](const auto& step) { return !ends.contains(step.first); });
  const bool cycle = start == link.end();
  std::size_t at = cycle ? link.begin()->first : start->first;
  std::size_t steps = 0;
  for (auto next = link.find(at); next != link.end() && steps < link.size(); next = link.find(at)) {
    at = next->second;
    ++steps;
  }
  return steps == link.size() && (!cycle || steps >= 3);
}

/// What is wrong with the mesh as an oriented manifold over the points of the cloud; empty if nothing.
std::string problem_of(const TriangleMesh& mesh, const PointCloud& cloud) {
  if (mesh.positions != cloud.positions) return "the vertices are not the points";
  Links links;
  if (std::string problem = links_of(mesh, links); !problem.empty()) return problem;
  for (const auto& [vertex, link] : links) {
    if (!is_one_chain(link)) return "the triangles at vertex " + std::to_string(vertex) + " are not one fan";
  }
  if (mesh.triangles.size() > 2 * cloud.size()) return "more than two triangles a point";
  return {};
}

/// Clouds of several thousand points, so that threads share the work.
std::vector<testing::NastyCloud> large_clouds() {
  std::vector<testing::NastyCloud> all;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> noise(0, 0.01);
  testing::NastyCloud sheets{"noisy sheets", {}};
  for (int i = 0; i < 5000; ++i) sheets.points.push_back({unit(random), unit(random), (i % 3) * 0.02 + noise(random)});
  testing::NastyCloud lattice{"lattice", {}};
  for (int i = 0; i < 15 * 15 * 15; ++i)
    lattice.points.push_back({1.0 * (i % 15), 1.0 * (i / 15 % 15), 1.0 * (i / 225)});
  testing::NastyCloud repeats{"repeats", testing::torus_points(90, 30)};
  repeats.points.insert(repeats.points.end(), repeats.points.begin(), repeats.points.begin() + 1000);
  testing::NastyCloud scales{"dense in sparse", testing::random_points(1500, 4)};
  for (Point3 p : testing::sphere_points(3000)) {
    for (double& x : p) x = 0.5 + 1e-6 * x;
    scales.points.push_back(p);
  }
  all.push_back(std::move(sheets));
  all.push_back(std::move(lattice));
  all.push_back(std::move(repeats));
  all.push_back(std::move(scales));
  all.push_back({"cube", testing::random_points(5000, 3)});
  return all;
}

std::vector<Parameters> variants() {
  return {Parameters{}, Parameters{.star = Parameters::Star::unfolded, .max_edge = 2},
          Parameters{.star = Parameters::Star::projected, .angle = Parameters::Angle::projected},
          Parameters{.seed = Parameters::Seed::paper},
          Parameters{.neighbours = 32, .fill_holes = Parameters::FillHoles::none}};
}

/// Checks the mesh, and that any order of the points and 1, 2 or 3 threads give the same one.
void check(const testing::NastyCloud& nasty, const Parameters& parameters, const std::string& name) {
  std::vector<Point3> points = nasty.points;
  std::optional<TriangleMesh> expected;
  std::mt19937 random(5);
  for (const unsigned threads : {1U, 2U, 3U}) {
    const PointCloud cloud = *make_cloud(testing::raw_cloud(points), threads);
    Context context(threads);
    const auto result = local_delaunay(cloud, parameters, context);
    if (!result) {
      const ErrorCode code = result.error().code;
      EXPECT_TRUE(code == ErrorCode::too_few_points || code == ErrorCode::collinear) << name;
      EXPECT_FALSE(expected) << name;
      continue;
    }
    if (!expected) {
      EXPECT_EQ(problem_of(result->mesh, cloud), "") << name;
      expected = result->mesh;
    }
    EXPECT_EQ(result->mesh.positions, expected->positions) << name;
    EXPECT_EQ(result->mesh.triangles, expected->triangles) << name;
    std::ranges::shuffle(points, random);
  }
}

TEST(LocalDelaunayProperties, hold_on_small_nasty_clouds_in_any_order_and_on_any_threads) {
  const auto all = variants();
  for (std::uint64_t number = 5000; number < 6100; ++number) {
    const testing::NastyCloud nasty = testing::NastyClouds::make(number);
    check(nasty, all[number / 11 % all.size()], nasty.kind + " " + std::to_string(number));
  }
}

TEST(LocalDelaunayProperties, hold_on_clouds_large_enough_for_threads_to_share) {
  for (const testing::NastyCloud& nasty : large_clouds()) {
    for (const Parameters& parameters : variants()) check(nasty, parameters, nasty.kind);
  }
}

TEST(LocalDelaunayProperties, no_edge_is_longer_than_max_edge_allows) {
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
}  // namespace surfaced
