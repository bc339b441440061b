// Points in a plane: the method against the 2-D Delaunay triangulation.
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "local_delaunay/local_delaunay.hpp"
#include "support/shapes.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::size_t, Kernel>;
using Delaunay2 = CGAL::Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<VertexBase, CGAL::Triangulation_face_base_2<Kernel>>>;
using Triple = std::array<std::size_t, 3>;

Triple sorted(std::size_t a, std::size_t b, std::size_t c) {
  Triple t{a, b, c};
  std::ranges::sort(t);
  return t;
}

/// Random points of a square of side 1, with coordinates that a tilted plane holds exactly: z = x + y/2.
PointCloud tilted_square(std::size_t n, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Point3> points(n);
  for (Point3& p : points) {
    const double x = std::ldexp(static_cast<double>(random() >> 6U), -26);
    const double y = std::ldexp(static_cast<double>(random() >> 6U), -26);
    p = {x, y, x + y / 2};
  }
  return *make_cloud(testing::raw_cloud(points));
}

TEST(LocalDelaunayInAPlane, equals_the_two_dimensional_delaunay_triangulation_inside_the_rim) {
  constexpr double kRim = 0.05;
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
    const PointCloud cloud = tilted_square(6000, seed);
    Context context;
    const auto result = local_delaunay(cloud, {}, context);
    ASSERT_TRUE(result);
    // Isometric coordinates up to scale, computed without rounding: u along (1, 0, 1) is not needed exactly; use
    // the plane's orthonormal frame in doubles, far more precise than points in general position ask for.
    const double root2 = std::sqrt(2.0);
    const double root54 = std::sqrt(1.25 - 0.125);
    Delaunay2 plane;
    for (std::size_t v = 0; v < cloud.size(); ++v) {
      const Point3& p = cloud.positions[v];
      // e1 = (1,0,1)/sqrt 2; e2 = (0,1,1/2) - (1/4)(1,0,1) = (-1/4, 1, 1/4), length sqrt(9/8).
      const double s = (p[0] + p[2]) / root2;
      const double t = (-p[0] / 4 + p[1] + p[2] / 4) / root54;
      plane.insert(Kernel::Point_2(s, t))->info() = v;
    }
    const auto inside = [&](std::size_t v) {
      const Point3& p = cloud.positions[v];
      return p[0] > kRim && p[0] < 1 - kRim && p[1] > kRim && p[1] < 1 - kRim;
    };
    std::set<Triple> expected;
    for (auto f = plane.finite_faces_begin(); f != plane.finite_faces_end(); ++f) {
      const Triple t = sorted(f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info());
      if (std::ranges::any_of(t, inside)) expected.insert(t);
    }
    std::set<Triple> found;
    for (const Triangle& t : result->mesh.triangles) {
      const Triple triple = sorted(t[0], t[1], t[2]);
      if (std::ranges::any_of(triple, inside)) found.insert(triple);
    }
    EXPECT_EQ(found, expected);
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
