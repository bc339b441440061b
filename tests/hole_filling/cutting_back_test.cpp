// SPDX-License-Identifier: GPL-3.0-or-later
// Before a hole is filled, triangles that are stretched into it or over it are taken away.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "hole_filling/hole_filling.hpp"
#include "support/holes.hpp"

namespace surfaced {
namespace {

using testing::bumpy_sphere;
using testing::cut_disc;
using testing::manifold_problem;

FillReport fill_all(TriangleMesh& mesh) {
  Context context;
  const Result<FillReport> report = fill_holes(mesh, {}, context);
  EXPECT_TRUE(report.ok());
  return report ? *report : FillReport{};
}

/// A sphere of 10,242 vertices, and triangles between the corners of a hole that was cut into it.
TriangleMesh spanned_sphere(const Point3& place, double radius) {
  const TriangleMesh whole = bumpy_sphere(5, 0);
  const testing::Cut cut = cut_disc(whole, place, radius);
  TriangleMesh mesh = cut.rest;
  std::map<VertexIndex, VertexIndex> next;  // around the hole, against its own triangles
  for (const Triangle& t : cut.removed.triangles) {
    for (std::size_t i = 0; i < 3; ++i) next[t[i]] = t[(i + 1) % 3];
  }
  std::set<std::pair<VertexIndex, VertexIndex>> directed;
  for (const Triangle& t : cut.removed.triangles) {
    for (std::size_t i = 0; i < 3; ++i) directed.emplace(t[i], t[(i + 1) % 3]);
  }
  for (const auto& [a, b] : directed) {
    if (!directed.contains({b, a})) next[a] = b;
  }
  const auto first = std::ranges::find_if(directed, [&](const auto& e) {
    return !directed.contains({e.second, e.first});
  });
  std::vector<VertexIndex> rim{first->first};
  while (next[rim.back()] != rim.front()) rim.push_back(next[rim.back()]);
  // A strip to and fro across the hole.
  for (std::size_t low = 0, high = rim.size() - 1; high - low > 1;) {
    mesh.triangles.push_back({rim[low], rim[low + 1], rim[high]});
    if (high - ++low > 1) {
      mesh.triangles.push_back({rim[low], rim[high - 1], rim[high]});
      --high;
    }
  }
  return mesh;
}

TEST(CuttingBack, opens_what_spans_a_hole_and_fills_it_as_densely_as_the_vertices_around_lie) {
  const Point3 place{0.6, 0.64, 0.48};
  const TriangleMesh spanned = spanned_sphere(place, 0.2);
  ASSERT_TRUE(topology_of(spanned).closed);
  TriangleMesh filled = spanned;
  const FillReport report = fill_all(filled);
  EXPECT_EQ(report.spans_opened, 1U);
  EXPECT_EQ(report.filled, 1U);
  EXPECT_GT(report.triangles_cut, 20U);
  const std::set<Triangle> before(spanned.triangles.begin(), spanned.triangles.end());
  const auto kept = std::ranges::count_if(filled.triangles, [&](const Triangle& t) { return before.contains(t); });
  EXPECT_EQ(static_cast<std::size_t>(kept) + report.triangles_cut, spanned.triangles.size());
  EXPECT_EQ(manifold_problem(filled), "");
  EXPECT_TRUE(topology_of(filled).closed);
  const auto lost = static_cast<double>(bumpy_sphere(5, 0).positions.size() - topology_of(spanned).vertices);
  const auto added = static_cast<double>(report.vertices_added);
  EXPECT_GT(lost, 90);
  EXPECT_NEAR(added, lost, 0.25 * lost);
  for (std::size_t v = spanned.positions.size(); v < filled.positions.size(); ++v) {
    EXPECT_NEAR(norm(filled.positions[v]), 1, 0.001);
  }
}

TEST(CuttingBack, leaves_a_span_as_it_was_where_nothing_better_covers_the_hole) {
  const Point3 place{0.6, 0.64, 0.48};
  TriangleMesh spanned = spanned_sphere(place, 0.2);
  // A needle through the middle of the hole: whatever covers it crosses that.
  const VertexIndex v(spanned.positions.size());
  for (const double shift : {-1e-3, 1e-3}) spanned.positions.push_back({0.6 * 0.5 + shift, 0.64 * 0.5, 0.48 * 0.5});
  spanned.positions.push_back({0.6 * 1.5, 0.64 * 1.5, 0.48 * 1.5});
  spanned.triangles.push_back({v, VertexIndex(v + 1), VertexIndex(v + 2)});
  TriangleMesh filled = spanned;
  const FillReport report = fill_all(filled);
  EXPECT_EQ(report.spans_opened, 0U);
  EXPECT_EQ(report.triangles_cut, 0U);
  EXPECT_EQ(filled.triangles, spanned.triangles);
}

}  // namespace
}  // namespace surfaced
