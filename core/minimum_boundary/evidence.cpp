// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/evidence.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/union_find.hpp"

namespace surfaced::boundary {
namespace {

bool same_topology(const Measures& a, const Measures& b) {
  return a.components == b.components && a.handles() == b.handles();
}

/// A volume beyond this is another body.
constexpr double kSameVolume = 1.25;

bool same_volume(const Measures& a, const Measures& b) {
  return a.volume <= kSameVolume * b.volume && b.volume <= kSameVolume * a.volume;
}

struct GuideTopology {
  std::size_t components = 0;
  std::int64_t genus = 0;
};

/// Of a guide without open edges.
GuideTopology topology_of_closed(const GuidingSurface& guide) {
  UnionFind parts(guide.positions.size());
  std::vector<std::uint8_t> used(guide.positions.size(), 0);
  for (const Triangle& t : guide.triangles) {
    for (const VertexIndex v : t) used[v] = 1;
    parts.unite(t[0], t[1]);
    parts.unite(t[0], t[2]);
  }
  GuideTopology topology;
  std::int64_t vertices = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0) continue;
    ++vertices;
    if (parts.find(v) == v) ++topology.components;
  }
  const std::int64_t euler = vertices - static_cast<std::int64_t>(guide.triangles.size()) / 2;
  topology.genus = static_cast<std::int64_t>(topology.components) - euler / 2;
  return topology;
}

std::vector<Point3> normals_of(const GuidingSurface& guide) {
  std::vector<Point3> normals(guide.positions.size(), Point3{});
  for (const Triangle& t : guide.triangles) {
    const Point3 n =
        cross(guide.positions[t[1]] - guide.positions[t[0]], guide.positions[t[2]] - guide.positions[t[0]]);
    for (const VertexIndex v : t) {
      for (std::size_t i = 0; i < 3; ++i) normals[v][i] += n[i];
    }
  }
  return normals;
}

Triangle sorted(Triangle t) {
  std::ranges::sort(t);
  return t;
}

}  // namespace

MinimumBoundaryEvidence compare_candidates(const std::vector<Candidate>& candidates, std::size_t chosen,
                                           std::size_t bodies) {
  MinimumBoundaryEvidence evidence;
  const Measures& own = candidates[chosen].measures;
  const Measures& first = candidates.front().measures;
  const Judge judge{static_cast<double>(first.energy) / static_cast<double>(first.facets), usual_handles(candidates)};
  std::size_t same = 0;
  std::size_t more = 0;
  std::size_t fewer = 0;
  evidence.gap = evidence.volume_gap = std::numeric_limits<double>::infinity();
  for (const Candidate& c : candidates) {
    const double apart = std::abs(judge.score(c.measures) - judge.score(own));
    if (same_topology(c.measures, own)) {
      ++same;
    } else if (bodies == 0 || c.measures.components == own.components) {
      evidence.gap = std::min(evidence.gap, apart);
    }
    if (!same_volume(c.measures, own)) evidence.volume_gap = std::min(evidence.volume_gap, apart);
    if (c.measures.handles() > own.handles()) ++more;
    if (c.measures.handles() < own.handles()) ++fewer;
    if (c.recipe.kind == Recipe::Kind::guided) evidence.guided_agrees = same_topology(c.measures, own);
  }
  const auto all = static_cast<double>(candidates.size());
  evidence.candidates_agreeing = static_cast<double>(same) / all;
  evidence.more_handles = static_cast<double>(more) / all;
  evidence.fewer_handles = static_cast<double>(fewer) / all;
  return evidence;
}

void compare_guide(const Labelling& labels, const Measures& measures, const GuidingSurface& guide,
                   MinimumBoundaryEvidence& evidence) {
  const DelaunayComplex& complex = labels.complex();
  const auto points = static_cast<double>(complex.points());
  evidence.guide_open_edges = static_cast<double>(guide.open_edges) / points;
  evidence.guide_unused = static_cast<double>(guide.unused_points) / points;
  if (guide.open_edges == 0 && !guide.triangles.empty()) {
    const GuideTopology topology = topology_of_closed(guide);
    evidence.guide_agrees = topology.components == measures.components && topology.genus == measures.handles();
  }
  const std::vector<Point3> normals = normals_of(guide);
  std::vector<Triangle> own;
  std::size_t opposed = 0;
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    if (!labels.in(CellIndex(s / 4)) || !labels.on_border(SideIndex(s))) continue;
    const Triangle t = complex.outward_facet(SideIndex(s));
    const Point3 n =
        cross(complex.positions[t[1]] - complex.positions[t[0]], complex.positions[t[2]] - complex.positions[t[0]]);
    const auto against = std::ranges::count_if(t, [&](VertexIndex v) { return dot(normals[v], n) < 0; });
    opposed += against > 1 ? 1U : 0U;
    own.push_back(sorted(t));
  }
  std::ranges::sort(own);
  const auto shared = std::ranges::count_if(
      guide.triangles, [&](const Triangle& t) { return std::ranges::binary_search(own, sorted(t)); });
  const auto count = static_cast<double>(own.size());
  evidence.opposed_triangles = static_cast<double>(opposed) / count;
  evidence.guide_shared = static_cast<double>(shared) / count;
}

}  // namespace surfaced::boundary
