// SPDX-License-Identifier: GPL-3.0-or-later
// Paper 3, table 2 and figure 3: reconstructed from the points alone.
#include <gtest/gtest.h>

#include "intrinsic_delaunay/intrinsic_delaunay.hpp"
#include "intrinsic_delaunay/surfaces.hpp"
#include "quality/quality.hpp"

namespace surfaced {
namespace {

TriangleMesh reconstruct(const std::vector<Point3>& points, const IntrinsicDelaunayParameters& parameters = {}) {
  Context context;
  auto result = intrinsic_delaunay(*make_cloud(testing::raw_cloud(points)), parameters, context);
  EXPECT_TRUE(result);
  return std::move(result->mesh);
}

/// A number to as many decimal places as the paper prints.
std::string printed(double x, int places) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%.*f", places, x);
  return text.data();
}

TEST(Table2, the_sphere_has_the_printed_counts_and_ratios) {
  const TriangleMesh mesh = reconstruct(testing::icosphere(3).positions);
  const Topology topology = topology_of(mesh);
  EXPECT_EQ(topology.vertices, 642U);
  EXPECT_EQ(topology.triangles, 1280U);
  EXPECT_TRUE(topology.closed);
  const MeshQuality quality = measure_quality(mesh, topology);
  EXPECT_EQ(printed(quality.shortest_edge_to_circumradius->min, 2), "1.62");
  EXPECT_EQ(printed(quality.shortest_edge_to_circumradius->max, 3), "1.732");
  EXPECT_EQ(printed(quality.inradius_to_longest_edge->min, 3), "0.255");
  EXPECT_EQ(printed(quality.inradius_to_longest_edge->max, 3), "0.289");
}

TEST(Table2, the_torus_has_the_printed_counts_and_ratios) {
  const TriangleMesh mesh = reconstruct(testing::torus_mesh(48, 16).positions);
  const Topology topology = topology_of(mesh);
  EXPECT_EQ(topology.vertices, 768U);
  EXPECT_EQ(topology.triangles, 1536U);
  EXPECT_TRUE(topology.closed);
  EXPECT_EQ(topology.genus, 1);
  const MeshQuality quality = measure_quality(mesh, topology);
  EXPECT_EQ(printed(quality.shortest_edge_to_circumradius->min, 2), "1.14");
  EXPECT_EQ(printed(quality.shortest_edge_to_circumradius->max, 3), "1.444");
  EXPECT_EQ(printed(quality.inradius_to_longest_edge->min, 3), "0.194");
  EXPECT_EQ(printed(quality.inradius_to_longest_edge->max, 3), "0.215");
}

TEST(Table2, a_knot_has_twice_as_many_faces_as_vertices_and_meets_the_bounds) {
  const TriangleMesh mesh = reconstruct(testing::knot_points(160, 8, 0.35));
  const Topology topology = topology_of(mesh);
  EXPECT_TRUE(topology.closed);
  EXPECT_EQ(topology.genus, 1);
  EXPECT_EQ(topology.vertices, 1280U);
  EXPECT_EQ(topology.triangles, 2 * topology.vertices);
  Context context;
  const auto certificate = certify(mesh, context);
  ASSERT_TRUE(certificate);
  EXPECT_TRUE(certificate->bounds.met());
  EXPECT_TRUE(certificate->bounds_at_largest_epsilon.met());
}

TEST(Figure3, the_patch_keeps_its_rim) {
  constexpr std::size_t kSide = 16;
  std::vector<Point3> points;
  for (std::size_t i = 0; i < kSide; ++i) {
    for (std::size_t j = 0; j < kSide; ++j) {
      const double u = std::numbers::pi / 2 * static_cast<double>(i) / (kSide - 1);
      const double v = std::numbers::pi / 2 * static_cast<double>(j) / (kSide - 1);
      points.push_back({u, v, std::cos(u) * std::sin(v)});
    }
  }
  const Topology topology = topology_of(reconstruct(points));
  EXPECT_EQ(topology.vertices, 256U);
  EXPECT_EQ(topology.triangles, 450U);
  EXPECT_EQ(topology.boundary_edges, 60U);
  EXPECT_EQ(topology.boundary_loops, 1U);
}

TEST(Figure4, the_bowl_keeps_its_rim_from_20_points_across_and_with_a_limit_from_16) {
  struct Sampling {
    std::size_t side;
    std::optional<double> max_edge;
  };
  for (const auto& [side, max_edge] : {Sampling{16, 2.5}, Sampling{20, std::nullopt}, Sampling{32, std::nullopt}}) {
    const auto cells = static_cast<double>(side - 1);
    std::vector<Point3> points;
    for (std::size_t i = 0; i < side; ++i) {
      for (std::size_t j = 0; j < side; ++j) {
        const double x = -1 + 2 * static_cast<double>(i) / cells;
        const double y = -1 + 2 * static_cast<double>(j) / cells;
        points.push_back({x, y, x * x + y * y});
      }
    }
    const Topology topology = topology_of(reconstruct(points, {.max_edge = max_edge}));
    EXPECT_EQ(topology.vertices, side * side);
    EXPECT_EQ(topology.triangles, 2 * (side - 1) * (side - 1));
    EXPECT_EQ(topology.boundary_edges, 4 * (side - 1));
    EXPECT_EQ(topology.boundary_loops, 1U);
  }
}

}  // namespace
}  // namespace surfaced
