// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/hole_covering.hpp"

#include <algorithm>
#include <array>

#include "minimum_boundary/hull.hpp"

namespace surfaced::boundary {
namespace {

/// Ball ratios that are tried as delta.
constexpr std::array kLadder{0.0, 1.0, 1.5, 1.6, 1.65, 1.7, 1.75, 1.8, 1.85, 1.9, 1.93, 1.96};

/// Facets of the set at the edge that the sides s and t of one cell share.
std::size_t facets_at_edge(const DelaunayComplex& complex, const FacetSet& facets, CellIndex c, unsigned a,
                           unsigned b) {
  std::size_t count = 0;
  EdgeWalk walk(complex, c, a, b);
  do {
    count += facets.contains(walk.exit()) ? 1U : 0U;
    walk.advance();
  } while (walk.cell() != c);
  return count;
}

/// Removes lids with an edge that no other facet shares, until there are none.
std::size_t prune(const DelaunayComplex& complex, FacetSet& facets, std::vector<SideIndex> lids) {
  const auto dangles = [&](SideIndex s) {
    const auto i = static_cast<unsigned>(s % 4);
    for (unsigned a = 0; a < 4; ++a) {
      for (unsigned b = a + 1; b < 4; ++b) {
        if (a != i && b != i && facets_at_edge(complex, facets, CellIndex(s / 4), a, b) == 1) return true;
      }
    }
    return false;
  };
  for (bool changed = true; changed;) {
    changed = false;
    std::erase_if(lids, [&](SideIndex s) {
      if (!dangles(s)) return false;
      facets.erase(complex, s);
      changed = true;
      return true;
    });
  }
  return lids.size();
}

}  // namespace

Covered cover_by_artifacts(const Walls& walls) {
  const DelaunayComplex& complex = walls.complex();
  Covered covered{walls.facets};
  std::vector<SideIndex> lids;
  std::vector<std::uint32_t> member_of(complex.points() + 1, 0);
  for (const Artifact& artifact : find_artifacts(walls)) {
    ++covered.artifacts;
    if (!artifact.hull_hole) continue;
    const auto number = static_cast<std::uint32_t>(++covered.hull_holes);
    for (const VertexIndex v : artifact.vertices) member_of[v] = number;
    for (const VertexIndex v : artifact.vertices) {
      for (const SideIndex corner : complex.star(v)) {
        const std::size_t c = corner / 4;
        for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
          const auto facet = complex.facet(SideIndex(s));
          const bool between = std::ranges::all_of(facet, [&](VertexIndex u) { return member_of[u] == number; });
          if (!between || covered.facets.contains(SideIndex(s))) continue;
          covered.facets.insert(complex, SideIndex(s));
          lids.emplace_back(s);
        }
      }
    }
  }
  covered.lids = prune(complex, covered.facets, std::move(lids));
  return covered;
}

FloodScore flood_score(const DelaunayComplex& complex, const FacetSet& walls, unsigned threads) {
  Labelling labels(complex);
  labels.assign(cells_behind(complex, walls), threads);
  FloodScore score;
  for (const VertexState state : states_of(labels, threads)) {
    if (!good(state)) ++score.lost;
    if (state == VertexState::interior) ++score.interior;
  }
  return score;
}

Covered cover_at(const DelaunayComplex& complex, const FacetSet& boundary, const BallRatio& ratio, double delta) {
  Covered covered{boundary};
  covered.delta = delta;
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (s > complex.mate(s) || boundary.contains(SideIndex(s))) continue;
    if (complex.facet(SideIndex(s))[2] == complex.points() || static_cast<double>(ratio.of(SideIndex(s))) >= delta) {
      continue;
    }
    covered.facets.insert(complex, SideIndex(s));
    ++covered.lids;
  }
  return covered;
}

Result<std::vector<Rung>> climb_ladder(const DelaunayComplex& complex, const FacetSet& boundary, const BallRatio& ratio,
                                       Context& context) {
  std::vector<Rung> rungs;
  for (const double delta : kLadder) {
    if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled while covering holes"};
    const Covered covered = cover_at(complex, boundary, ratio, delta);
    rungs.push_back({delta, flood_score(complex, covered.facets, context.threads())});
    context.report(static_cast<double>(rungs.size()) / static_cast<double>(kLadder.size()));
  }
  return rungs;
}

Result<Covered> cover_by_balls(const DelaunayComplex& complex, const FacetSet& boundary, std::optional<double> delta,
                               Context& context) {
  const BallRatio ratio(complex, context.threads());
  if (!delta) {
    const Result<std::vector<Rung>> rungs = climb_ladder(complex, boundary, ratio, context);
    if (!rungs) return rungs.error();
    delta = std::ranges::min_element(*rungs, {}, [](const Rung& r) { return r.score.sum(); })->delta;
  }
  return cover_at(complex, boundary, ratio, *delta);
}

}  // namespace surfaced::boundary
