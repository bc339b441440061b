// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/hole_covering.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <optional>

#include "base/union_find.hpp"
#include "minimum_boundary/hull.hpp"

namespace surfaced::boundary {
namespace {

/// The outside leaks in while more than this share of the points is lost to it.
constexpr double kLeak = 0.1;
/// The same for lids between all artifacts, which are chosen by nothing but this.
constexpr double kLeakOfAll = 0.02;
constexpr unsigned kNarrowRounds = 3;
constexpr unsigned kRounds = 4;
constexpr unsigned kHalvings = 12;
constexpr std::uint32_t kNoHole = 0xFFFFFFFFU;
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

bool dangles(const DelaunayComplex& complex, const FacetSet& facets, SideIndex s) {
  const auto i = static_cast<unsigned>(s % 4);
  for (unsigned a = 0; a < 4; ++a) {
    for (unsigned b = a + 1; b < 4; ++b) {
      if (a != i && b != i && facets_at_edge(complex, facets, CellIndex(s / 4), a, b) == 1) return true;
    }
  }
  return false;
}

/// Removes lids with an edge that no other facet shares, until there are none.
std::size_t prune(const DelaunayComplex& complex, FacetSet& facets, const std::vector<SideIndex>& lids) {
  FacetSet left(complex);
  for (const SideIndex s : lids) left.insert(complex, s);
  std::size_t count = lids.size();
  std::vector<SideIndex> stack(lids);
  while (!stack.empty()) {
    const SideIndex s = stack.back();
    stack.pop_back();
    if (!left.contains(s) || !dangles(complex, facets, s)) continue;
    facets.erase(complex, s);
    left.erase(complex, s);
    --count;
    for (const auto& [a, b] : kCellEdges) {
      if (a == s % 4 || b == s % 4) continue;
      EdgeWalk walk(complex, CellIndex(s / 4), a, b);
      do {
        if (left.contains(walk.exit())) stack.push_back(walk.exit());
        walk.advance();
      } while (walk.cell() != CellIndex(s / 4));
    }
  }
  return count;
}

/// The vertices of every hull hole: artifacts with holes bound the same one where they share a vertex. With `all`,
/// artifacts without one count too: the outside may have entered slivers of the rim.
std::vector<std::uint32_t> holes_of(const std::vector<Artifact>& artifacts, std::size_t points, bool all) {
  UnionFind groups(points);
  std::vector<std::uint32_t> hole_of(points, kNoHole);
  for (const Artifact& artifact : artifacts) {
    if (!artifact.hull_hole && !all) continue;
    for (const VertexIndex v : artifact.vertices) {
      groups.unite(artifact.vertices.front(), v);
      hole_of[v] = 0;
    }
  }
  for (std::size_t v = 0; v < points; ++v) {
    if (hole_of[v] != kNoHole) hole_of[v] = groups.find(v);
  }
  return hole_of;
}

/// One hole through all artifacts and all points that the surface does not pass or touches twice.
std::vector<std::uint32_t> one_hole(const std::vector<Artifact>& artifacts, const Labelling& labels) {
  std::vector<std::uint32_t> hole_of(labels.complex().points(), kNoHole);
  const std::vector<VertexState> states = states_of(labels, 1);
  for (std::size_t v = 0; v < hole_of.size(); ++v) {
    if (!good(states[v])) hole_of[v] = 0;
  }
  for (const Artifact& artifact : artifacts) {
    for (const VertexIndex v : artifact.vertices) hole_of[v] = 0;
  }
  return hole_of;
}

/// All facets of the triangulation between the vertices of one hole that are not there yet, by ascending λ.
std::vector<SideIndex> lids_between(const Criterion& criterion, const DelaunayComplex& complex, const FacetSet& facets,
                                    const std::vector<std::uint32_t>& hole_of) {
  std::vector<SideIndex> lids;
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (s > complex.mate(s) || facets.contains(SideIndex(s))) continue;
    const auto facet = complex.facet(SideIndex(s));
    if (facet[2] == complex.points() || hole_of[facet[0]] == kNoHole) continue;
    if (hole_of[facet[0]] == hole_of[facet[1]] && hole_of[facet[0]] == hole_of[facet[2]]) lids.emplace_back(s);
  }
  std::ranges::sort(lids, [&](SideIndex a, SideIndex b) { return criterion.less(a, b); });
  return lids;
}

/// BC with the first lids.
Covered cover_with(const Walls& walls, const std::vector<SideIndex>& lids, std::size_t count) {
  Covered covered{walls.facets};
  const std::vector<SideIndex> first(lids.begin(), lids.begin() + static_cast<std::ptrdiff_t>(count));
  for (const SideIndex s : first) covered.facets.insert(walls.complex(), s);
  covered.lids = prune(walls.complex(), covered.facets, first);
  return covered;
}

/// What the outside takes once lids are there.
Labelling flooded(const Walls& walls, const FacetSet& facets) {
  std::vector<std::uint8_t> in = cells_behind(walls.complex(), facets);
  for (std::size_t c = 0; c < in.size(); ++c) in[c] = in[c] != 0 || walls.labels.in(CellIndex(c)) ? 1 : 0;
  Labelling labels(walls.complex());
  labels.assign(in, 1);
  return labels;
}

/// Share of the points that the surface does not pass or touches twice.
double lost_share(const Labelling& labels) {
  const std::vector<VertexState> states = states_of(labels, 1);
  const auto lost = std::ranges::count_if(states, [](VertexState state) { return !good(state); });
  return static_cast<double>(lost) / static_cast<double>(states.size());
}

/// The shortest lids with which no more than a share of the points is lost, to within 1/2^kHalvings of their number;
/// all where not even they do.
Covered least_cover(const Walls& walls, const std::vector<SideIndex>& lids, double share) {
  std::size_t low = 0;
  std::size_t high = lids.size();
  for (unsigned k = 0; k < kHalvings && high - low > 1; ++k) {
    const std::size_t middle = low + (high - low) / 2;
    const bool leaks = lost_share(flooded(walls, cover_with(walls, lids, middle).facets)) > share;
    (leaks ? low : high) = middle;
  }
  return cover_with(walls, lids, high);
}

/// Lids of all hull holes, sought again as long as the outside leaks in: lids part pockets off in which BC folds too.
/// @return  By ascending λ; nothing if they do not keep the outside out.
std::optional<std::vector<SideIndex>> local_lids(const Walls& walls, const Criterion& criterion, Covered& covered) {
  const DelaunayComplex& complex = walls.complex();
  Labelling labels = walls.labels;
  std::vector<SideIndex> lids;
  for (unsigned round = 0; round < kRounds; ++round) {
    const std::vector<Artifact> artifacts = find_artifacts({labels, covered.facets});
    if (round == 0) {
      covered.artifacts = artifacts.size();
      covered.hull_holes = static_cast<std::size_t>(std::ranges::count_if(artifacts, &Artifact::hull_hole));
    }
    const auto added =
        lids_between(criterion, complex, covered.facets, holes_of(artifacts, complex.points(), round >= kNarrowRounds));
    for (const SideIndex s : added) covered.facets.insert(complex, s);
    prune(complex, covered.facets, added);
    std::ranges::copy_if(added, std::back_inserter(lids), [&](SideIndex s) { return covered.facets.contains(s); });
    labels = flooded(walls, covered.facets);
    if (lost_share(labels) > (round < kNarrowRounds ? kLeak : kLeakOfAll)) continue;
    std::ranges::sort(lids, [&](SideIndex a, SideIndex b) { return criterion.less(a, b); });
    return lids;
  }
  return std::nullopt;
}

}  // namespace

Covered cover_by_artifacts(const Walls& walls, const Criterion& criterion) {
  const DelaunayComplex& complex = walls.complex();
  Covered tried{walls.facets};
  const auto local = local_lids(walls, criterion, tried);
  Covered covered{walls.facets};
  if (local) {
    covered = least_cover(walls, *local, kLeak);
  } else {
    const auto hole = one_hole(find_artifacts(walls), flooded(walls, walls.facets));
    covered = least_cover(walls, lids_between(criterion, complex, walls.facets, hole), kLeakOfAll);
  }
  covered.artifacts = tried.artifacts;
  covered.hull_holes = tried.hull_holes;
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
