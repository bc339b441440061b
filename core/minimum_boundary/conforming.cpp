// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/conforming.hpp"

#include <algorithm>

#include "minimum_boundary/inflating.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::size_t kSides = 2;

/// First cell of every run of outside cells between two walls around an edge, in the order of the walk.
std::vector<CellIndex> outside_runs(const Walls& walls, CellIndex c, unsigned a, unsigned b) {
  std::vector<CellIndex> runs;
  EdgeWalk walk(walls.complex(), c, a, b);
  do {
    if (!walls.labels.in(walk.cell()) && walls.contains(walk.entry())) runs.push_back(walk.cell());
    walk.advance();
  } while (walk.cell() != c);
  return runs;
}

/// Deflated edges at v as the groups of outside cells that see them, a bit for each group.
struct DeflatedEdges {
  bool well_formed = true;
  std::vector<unsigned> seen_by;
};

DeflatedEdges deflated_edges(const Walls& walls, const std::vector<WalledStar::Group>& groups, VertexIndex v) {
  const DelaunayComplex& complex = walls.complex();
  DeflatedEdges edges;
  for (const SideIndex corner : complex.star(v)) {
    const CellIndex c = DelaunayComplex::cell_of(corner);
    for (unsigned other = 0; other < 4; ++other) {
      if (other == corner % 4 || complex.vertex(4 * c + other) == complex.points()) continue;
      const std::vector<CellIndex> runs = outside_runs(walls, c, static_cast<unsigned>(corner % 4), other);
      if (runs.size() < 2) continue;
      if (runs.size() > kSides) edges.well_formed = false;
      unsigned seen = 0;
      for (std::size_t g = 0; g < groups.size(); ++g) {
        for (const CellIndex run : runs) {
          if (std::ranges::find(groups[g].cells, run) != groups[g].cells.end())
            seen |= 1U << std::min<std::size_t>(g, 31);
        }
      }
      edges.seen_by.push_back(seen);
    }
  }
  return edges;
}

}  // namespace

bool conforms(const Walls& walls, WalledStar& star, VertexIndex v) {
  const std::vector<WalledStar::Group>& groups = star.groups(walls, v);
  const auto outside = std::ranges::count_if(groups, [](const WalledStar::Group& g) { return g.outside; });
  if (outside > static_cast<std::ptrdiff_t>(kSides)) return false;
  const DeflatedEdges edges = deflated_edges(walls, groups, v);
  if (!edges.well_formed) return false;
  if (edges.seen_by.empty()) return outside < 2;
  unsigned by_all = ~0U;
  for (const unsigned seen : edges.seen_by) by_all &= seen;
  return by_all != 0;
}

Result<std::size_t> make_conforming(Labelling& labels, const FacetSet& facets, const Criterion& criterion,
                                    const Context& context) {
  WalledStar star(labels.complex());
  const VertexTest passes = [&](const Labelling& l, VertexIndex v) { return conforms(Walls{l, facets}, star, v); };
  return inflate_until(labels, facets, criterion, passes, context, 1);
}

}  // namespace surfaced::boundary
