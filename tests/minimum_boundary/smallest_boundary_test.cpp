// SPDX-License-Identifier: GPL-3.0-or-later
// The paper's conjecture (§8) that the method finds B_min, on clouds so small that all labellings can be tried.
#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <optional>
#include <random>

#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/measures.hpp"
#include "minimum_boundary/minimum_boundary.hpp"
#include "support/shapes.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kMostCells = 18;

/// Least Σλ of all labellings of the finite cells whose surface is one manifold through every point (B_min,
/// equation 2); none if there is no such surface. The labellings come in the order of a Gray code: each differs
/// from the one before in one cell.
std::optional<double> least_sum(const DelaunayComplex& complex) {
  const Criterion criterion(complex);
  std::vector<CellIndex> cells;
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    if (!complex.infinite(CellIndex(c))) cells.emplace_back(c);
  }
  Labelling labels(complex);
  std::vector<std::uint8_t> on_surface(complex.points(), 0);
  std::size_t missing = complex.points();
  std::int64_t energy = 0;
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (std::uint64_t step = 1; step < std::uint64_t{1} << cells.size(); ++step) {
    const CellIndex c = cells[static_cast<std::size_t>(std::countr_zero(step))];
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
      energy += labels.on_border(SideIndex(s)) ? -criterion.energy(SideIndex(s)) : criterion.energy(SideIndex(s));
    }
    labels.flip(c);
    for (std::size_t i = 4 * c; i < 4 * c + 4; ++i) {
      const VertexIndex v = complex.vertex(i);
      const std::uint8_t now = labels.state(v) == VertexState::surface ? 1 : 0;
      missing = missing + on_surface[v] - now;
      on_surface[v] = now;
    }
    if (missing == 0 && energy < least && measure(labels, criterion).components == 1) least = energy;
  }
  if (least == std::numeric_limits<std::int64_t>::max()) return std::nullopt;
  return criterion.length(least);
}

struct Tally {
  std::size_t clouds = 0;
  std::size_t without_any = 0;
  std::size_t points_inside = 0;
  std::size_t equal = 0;
  double worst_gap = 0;
  double sum_of_gaps = 0;
};

void compare(const std::vector<Point3>& points, const MinimumBoundaryParameters& parameters, Tally& tally) {
  const PointCloud cloud = *make_cloud(testing::raw_cloud(points));
  Context context;
  const auto complex = delaunay_complex(cloud, context, 1);
  if (!complex) return;
  std::size_t finite = 0;
  for (std::size_t c = 0; c < complex->cells(); ++c) finite += complex->infinite(CellIndex(c)) ? 0U : 1U;
  if (finite > kMostCells) return;
  ++tally.clouds;
  const std::optional<double> least = least_sum(*complex);
  Context again;
  const auto result = minimum_boundary(cloud, parameters, again);
  ASSERT_TRUE(result);
  const MinimumBoundaryStatistics& s = result->statistics;
  if (!least) {
    ++tally.without_any;
    EXPECT_TRUE(s.interior_vertices > 0 || s.components > 1);
    return;
  }
  if (s.interior_vertices > 0 || s.components > 1) {
    ++tally.points_inside;
    return;
  }
  const double gap = s.sum_lambda / *least - 1;
  EXPECT_GE(gap, -1e-12);
  if (gap < 1e-12) ++tally.equal;
  tally.worst_gap = std::max(tally.worst_gap, gap);
  tally.sum_of_gaps += gap;
}

void print(const std::string& name, const Tally& t) {
  const auto measured = static_cast<double>(t.clouds - t.without_any - t.points_inside);
  std::cout << name << ": " << t.clouds << " clouds, " << t.without_any << " have no surface through all points, "
            << t.points_inside << " with points left inside though there is one, " << t.equal
            << " at the minimum; gap mean " << 100 * t.sum_of_gaps / measured << " %, worst " << 100 * t.worst_gap
            << " %\n";
}

/// More by the environment variable SURFACED_TINY_CLOUDS.
std::size_t cloud_count() {
  const char* text = std::getenv("SURFACED_TINY_CLOUDS");  // NOLINT(concurrency-mt-unsafe): nobody sets it
  return text != nullptr ? std::strtoul(text, nullptr, 10) : 150;
}

Tally tally_of(const std::string& kind, MinimumBoundaryParameters::Variant variant) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  Tally tally;
  for (std::size_t k = 0; k < cloud_count(); ++k) {
    const std::size_t n = 5 + k % 5;
    std::vector<Point3> points;
    for (std::size_t i = 0; i < n; ++i) {
      Point3 p{unit(random), unit(random), unit(random)};
      if (kind == "lattice") p = {std::floor(3 * p[0]), std::floor(3 * p[1]), std::floor(3 * p[2])};
      if (kind == "sphere") {
        const double z = 2 * p[0] - 1;
        const double angle = 2 * std::numbers::pi * p[1];
        const double r = std::sqrt(1 - z * z);
        p = {r * std::cos(angle), r * std::sin(angle), z};
      }
      points.push_back(p);
    }
    compare(points, {.variant = variant, .diagonals = MinimumBoundaryParameters::Diagonals::shortest}, tally);
  }
  print(kind, tally);
  return tally;
}

using Variant = MinimumBoundaryParameters::Variant;

TEST(SmallestBoundary, best_never_goes_below_it_and_meets_it_for_most_points_of_a_sphere) {
  const Tally t = tally_of("sphere", Variant::best);
  EXPECT_EQ(t.without_any, 0U);
  EXPECT_GT(t.equal, t.clouds / 2);
}

TEST(SmallestBoundary, best_never_goes_below_it_on_points_scattered_in_a_cube) { tally_of("cube", Variant::best); }

TEST(SmallestBoundary, best_never_goes_below_it_on_points_of_a_lattice) { tally_of("lattice", Variant::best); }

TEST(SmallestBoundary, fast_and_papers_way_never_go_below_it) {
  tally_of("cube", Variant::fast);
  tally_of("cube", Variant::paper);
  tally_of("sphere", Variant::fast);
  tally_of("sphere", Variant::paper);
}

}  // namespace
}  // namespace surfaced::boundary
