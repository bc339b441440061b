// SPDX-License-Identifier: GPL-3.0-or-later
// The steps of the paper, each with what goes missing when it is left out.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "minimum_boundary/artifacts.hpp"
#include "minimum_boundary/conforming.hpp"
#include "minimum_boundary/descent.hpp"
#include "minimum_boundary/hole_covering.hpp"
#include "minimum_boundary/hull.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/minimum_boundary.hpp"
#include "minimum_boundary/sculpturing.hpp"
#include "support/nasty_clouds.hpp"

namespace surfaced::boundary {
namespace {

/// A cloud with its boundary complex, the outside flooded up to it.
struct Start {
  DelaunayComplex complex;
  Criterion criterion;
  FacetSet facets;
  Labelling labels;

  Start(DelaunayComplex made, bool connected)
      : complex(std::move(made)), criterion(complex), facets(boundary(complex, criterion, connected)), labels(complex) {
    labels.assign(cells_behind(complex, facets), 1);
  }
  Walls walls() const { return {labels, facets}; }

 private:
  static FacetSet boundary(const DelaunayComplex& complex, const Criterion& criterion, bool connected) {
    Context context;
    return boundary_complex(complex, criterion, connected, context)->facets;
  }
};

DelaunayComplex complex_of(const std::vector<Point3>& points) {
  Context context;
  return *delaunay_complex(*make_cloud(testing::raw_cloud(points)), context, 1);
}

std::vector<Point3> open_sphere() {
  std::vector<Point3> points = testing::sphere_points(600);
  std::erase_if(points, [](const Point3& p) { return p[2] > 0.5; });
  return points;
}

double squared_circumradius(const DelaunayComplex& complex, SideIndex s) {
  const auto [a, b, c] = complex.facet(s);
  const Point3 u = complex.positions[b] - complex.positions[a];
  const Point3 v = complex.positions[c] - complex.positions[a];
  const Point3 w = complex.positions[c] - complex.positions[b];
  const Point3 n = cross(u, v);
  const double squared = dot(u, u) * dot(v, v) * dot(w, w) / (4 * dot(n, n));
  return std::isnan(squared) ? INFINITY : squared;
}

/// Figure 10 and §6.3, every test made from scratch for every cell at every step.
void sculpture_slowly(Labelling& labels, Labelling& core, const Criterion& criterion) {
  const DelaunayComplex& complex = labels.complex();
  const auto longest_removed = [&](const Labelling& side, CellIndex c) -> std::optional<double> {
    const unsigned border = side.border(c);
    if (std::popcount(border) != 1 && std::popcount(border) != 2) return std::nullopt;
    std::array<SideIndex, 4> by_radius;
    for (std::size_t i = 0; i < 4; ++i) by_radius[i] = SideIndex(4 * c + i);
    std::ranges::sort(by_radius, [&](SideIndex a, SideIndex b) {
      const double ra = squared_circumradius(complex, a);
      const double rb = squared_circumradius(complex, b);
      return ra != rb ? ra < rb : criterion.less(a, b);
    });
    if ((border >> (by_radius[0] % 4) & 1U) != 0 || !flip_is_legal(side, c)) return std::nullopt;
    double longest = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if ((border >> i & 1U) != 0) longest = std::max(longest, criterion.squared(SideIndex(4 * c + i)));
    }
    return longest;
  };
  for (;;) {
    double longest = -1;
    CellIndex best;
    Labelling* taker = nullptr;
    for (std::size_t c = 0; c < complex.cells(); ++c) {
      if (!labels.in(CellIndex(c)) || core.in(CellIndex(c))) continue;
      for (Labelling* side : {&labels, &core}) {
        const auto removed = longest_removed(*side, CellIndex(c));
        if (!removed || *removed <= longest) continue;
        longest = *removed;
        best = CellIndex(c);
        taker = side;
      }
    }
    if (taker == nullptr) return;
    taker->flip(best);
  }
}

TEST(Sculpturing, takes_the_cells_that_the_rules_give_step_by_step) {
  std::size_t taken = 0;
  std::size_t differs_without_core = 0;
  for (std::uint64_t number = 9000; number < 9120; ++number) {
    Context context;
    auto complex =
        delaunay_complex(*make_cloud(testing::raw_cloud(testing::NastyClouds::make(number).points)), context, 1);
    if (!complex || complex->points() > 40) continue;
    Start start(std::move(*complex), true);
    ASSERT_TRUE(inflate(start.labels, start.facets, start.criterion, context, 1));
    Labelling expected = start.labels;
    Labelling core(start.complex);
    core.assign(inside_hull(start.labels, start.facets), 1);
    sculpture_slowly(expected, core, start.criterion);
    const auto sculptured = sculpture(start.labels, start.facets, start.criterion, context);
    ASSERT_TRUE(sculptured);
    EXPECT_TRUE(start.labels == expected) << number;
    taken += sculptured->exposed + sculptured->flipped;
    differs_without_core += sculptured->core > 0 ? 1U : 0U;
  }
  EXPECT_GT(taken, 50U);
  EXPECT_GT(differs_without_core, 5U);
}

TEST(Artifacts, a_wide_opening_is_a_hull_hole_and_a_closed_sphere_has_none) {
  const Start open(complex_of(open_sphere()), true);
  EXPECT_TRUE(std::ranges::any_of(find_artifacts(open.walls()), [](const Artifact& a) { return a.hull_hole; }));
  const Start closed(complex_of(testing::sphere_points(600)), true);
  EXPECT_FALSE(std::ranges::any_of(find_artifacts(closed.walls()), [](const Artifact& a) { return a.hull_hole; }));
}

TEST(HoleCovering, lids_of_a_hull_hole_keep_the_outside_out) {
  const Start open(complex_of(open_sphere()), true);
  const Covered covered = cover_by_artifacts(open.walls(), open.criterion);
  EXPECT_GT(covered.hull_holes, 0U);
  EXPECT_GT(covered.lids, 0U);
  const FloodScore before = flood_score(open.complex, open.facets, 1);
  const FloodScore after = flood_score(open.complex, covered.facets, 1);
  EXPECT_LT(after.lost, before.lost / 2);
  EXPECT_LT(covered.lids, open.complex.cells() / 2) << "a quarter of all facets: lids percolate";
}

TEST(Conforming, takes_cells_in_until_every_vertex_conforms_or_has_no_more_to_take) {
  std::size_t taken = 0;
  std::size_t failed_before = 0;
  std::size_t failed_after = 0;
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    Start start(complex_of(testing::random_torus(200, seed)), true);
    WalledStar star(start.complex);
    const auto failing = [&] {
      std::size_t count = 0;
      for (std::size_t v = 0; v < start.complex.points(); ++v) {
        count += conforms(start.walls(), star, VertexIndex(v)) ? 0U : 1U;
      }
      return count;
    };
    failed_before += failing();
    Context context;
    const auto cells = make_conforming(start.labels, start.facets, start.criterion, context);
    ASSERT_TRUE(cells);
    taken += *cells;
    failed_after += failing();
  }
  EXPECT_GT(failed_before, 0U);
  EXPECT_GT(taken, 0U);
  EXPECT_EQ(failed_after, 0U);
}

TEST(PapersWay, reports_every_step_that_it_takes) {
  Context context;
  const auto result = minimum_boundary(*make_cloud(testing::raw_cloud(open_sphere())),
                                       {.variant = MinimumBoundaryParameters::Variant::paper}, context);
  ASSERT_TRUE(result);
  EXPECT_GT(result->statistics.artifacts, 0U);
  EXPECT_GT(result->statistics.hull_holes, 0U);
  EXPECT_GT(result->statistics.lids, 0U);
  EXPECT_GT(result->statistics.flipped_edges, 0U);
}

}  // namespace
}  // namespace surfaced::boundary
