// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/spanning.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "base/union_find.hpp"
#include "mesh/area_normal.hpp"

namespace surfaced {
namespace {

/// Measured on 9 seeds of hemispheres, tunnels, vaults, catenoids, spheres with holes and terrains with lakes, against
/// closed bodies of the same numbers of points, some a third as dense on one side: the openings have areas of 96
/// squared circumradii (the median at their corners) or more, the largest gap of a closed body 12.
constexpr double kLongCircumradius = 3;
constexpr double kOpeningArea = 36;
/// Bars between rims are narrow, and known by their length: seven spacings.
constexpr double kLongBar = 12;

double squared_length(const TriangleMesh& mesh, VertexIndex a, VertexIndex b) {
  const Point3 d = mesh.positions[b] - mesh.positions[a];
  return dot(d, d);
}

/// At every vertex the second smallest circumradius of its triangles, or the only one.
std::vector<float> circumradii_at_vertices(const TriangleMesh& mesh, const std::vector<float>& radii) {
  constexpr float kNone = std::numeric_limits<float>::infinity();
  std::vector<std::pair<float, float>> least(mesh.positions.size(), {kNone, kNone});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const VertexIndex v : mesh.triangles[t]) {
      auto& [first, second] = least[v];
      if (radii[t] < first) {
        second = std::exchange(first, radii[t]);
      } else {
        second = std::min(second, radii[t]);
      }
    }
  }
  std::vector<float> result;
  result.reserve(least.size());
  for (const auto& [first, second] : least) result.push_back(second < kNone ? second : first);
  return result;
}

/// Whether the set is as large as an opening, or, as a bar, as long as one, against the lower quartile of the
/// circumradii at its corners.
bool is_opening(const TriangleMesh& mesh, const SpannedOpening& set, const std::vector<float>& at_vertex, bool bar) {
  double area = 0;
  std::vector<float> scales;
  for (const std::uint32_t t : set.triangles) {
    area += norm(area_normal(mesh, mesh.triangles[t])) / 2;
    for (const VertexIndex v : mesh.triangles[t]) scales.push_back(at_vertex[v]);
  }
  const auto quarter = scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 4);
  std::ranges::nth_element(scales, quarter);
  const auto scale = static_cast<double>(*quarter);
  return area > kOpeningArea * scale * scale || (bar && set.longest_edge > kLongBar * scale);
}

/// Triangles of every fan but the largest, where a vertex has several.
std::vector<bool> in_smaller_fans(const TriangleMesh& mesh) {
  UnionFind fans = fans_of_corners(mesh);
  std::vector<std::uint32_t> size(fans.size(), 0);
  for (std::size_t h = 0; h < fans.size(); ++h) ++size[fans.find(h)];
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> largest(mesh.positions.size(), kNone);
  const auto corner = [&](std::size_t h) { return mesh.triangles[h / 3].at(h % 3); };
  for (std::size_t h = 0; h < fans.size(); ++h) {
    std::uint32_t& best = largest[corner(h)];
    const std::uint32_t fan = fans.find(h);
    if (best == kNone || size[fan] > size[best]) best = fan;
  }
  std::vector<bool> smaller(mesh.triangles.size(), false);
  for (std::size_t h = 0; h < fans.size(); ++h) {
    if (fans.find(h) != largest[corner(h)]) smaller[h / 3] = true;
  }
  return smaller;
}

/// Circumradii of all triangles, and what they are usually at every vertex.
struct Scales {
  explicit Scales(const TriangleMesh& mesh) {
    radii.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) radii.push_back(static_cast<float>(circumradius(mesh, t)));
    at_vertex = circumradii_at_vertices(mesh, radii);
  }

  /// Against the corner of largest, or of middle, circumradius: at a rim two of the three may know slivers alone.
  bool is_large(const TriangleMesh& mesh, std::size_t t, bool against_middle) const {
    const auto [a, b, c] = mesh.triangles[t];
    std::array<float, 3> usual{at_vertex[a], at_vertex[b], at_vertex[c]};
    std::ranges::sort(usual);
    const auto limit = kLongCircumradius * static_cast<double>(usual.at(against_middle ? 1 : 2));
    return limit > 0 && static_cast<double>(radii[t]) > limit;
  }

  std::vector<float> radii;
  std::vector<float> at_vertex;
};

std::size_t drop(TriangleMesh& mesh, const std::vector<bool>& dropped) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < dropped.size(); ++t) {
    if (!dropped[t]) mesh.triangles[kept++] = mesh.triangles[t];
  }
  mesh.triangles.resize(kept);
  return dropped.size() - kept;
}

/// The sets of large triangles that are openings.
template <class IsLarge>
std::vector<SpannedOpening> openings_among(const TriangleMesh& mesh, const Scales& scales, bool bars,
                                           IsLarge is_large) {
  std::vector<std::uint32_t> large;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (is_large(t)) large.push_back(static_cast<std::uint32_t>(t));
  }
  std::vector<SpannedOpening> openings;
  for (std::vector<std::uint32_t>& set : sets_across_edges(mesh, large)) {
    double longest = 0;
    for (const std::uint32_t t : set) {
      for (std::size_t k = 0; k < 3; ++k) {
        longest = std::max(longest, squared_length(mesh, mesh.triangles[t].at(k), mesh.triangles[t].at((k + 1) % 3)));
      }
    }
    SpannedOpening found{std::move(set), std::sqrt(longest)};
    if (is_opening(mesh, found, scales.at_vertex, bars)) openings.push_back(std::move(found));
  }
  return openings;
}

/// The vertices of edges with one triangle.
std::vector<bool> rim_of(const TriangleMesh& mesh, const HalfEdges& half_edges) {
  std::vector<bool> on_rim(mesh.positions.size(), false);
  for (std::size_t h = 0; h < 3 * mesh.triangles.size(); ++h) {
    if (half_edges.uses(half_edges.edge_of(HalfEdgeIndex(h))) != 1) continue;
    const Triangle& t = mesh.triangles[h / 3];
    on_rim[t.at(h % 3)] = on_rim[t.at((h + 1) % 3)] = true;
  }
  return on_rim;
}

/// What still spans an opening between its rims, where two corners of a triangle may have none but large ones.
std::vector<SpannedOpening> bridges(const TriangleMesh& mesh) {
  const Scales scales(mesh);
  const std::vector<bool> on_rim = rim_of(mesh, HalfEdges(mesh.triangles, mesh.positions.size()));
  return openings_among(mesh, scales, true, [&](std::size_t t) {
    const bool between = std::ranges::all_of(mesh.triangles[t], [&](VertexIndex v) { return on_rim[v]; });
    return between && scales.is_large(mesh, t, true);
  });
}

}  // namespace

std::vector<std::vector<std::uint32_t>> sets_across_edges(const TriangleMesh& mesh,
                                                          const std::vector<std::uint32_t>& list) {
  struct Side {
    std::pair<VertexIndex, VertexIndex> edge;
    std::size_t at;
  };
  std::vector<Side> sides;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Triangle& t = mesh.triangles[list[i]];
    for (std::size_t k = 0; k < 3; ++k) sides.push_back({std::minmax(t[k], t[(k + 1) % 3]), i});
  }
  std::ranges::sort(sides,
                    [](const Side& a, const Side& b) { return std::tie(a.edge, a.at) < std::tie(b.edge, b.at); });
  UnionFind sets(list.size());
  for (std::size_t s = 1; s < sides.size(); ++s) {
    if (sides[s].edge == sides[s - 1].edge) sets.unite(sides[s - 1].at, sides[s].at);
  }
  std::vector<std::vector<std::uint32_t>> result;
  std::map<std::uint32_t, std::size_t> number;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto [found, fresh] = number.try_emplace(sets.find(i), result.size());
    if (fresh) result.emplace_back();
    result[found->second].push_back(list[i]);
  }
  return result;
}

std::vector<SpannedOpening> spanned_openings(const TriangleMesh& mesh) {
  const Scales scales(mesh);
  return openings_among(mesh, scales, false, [&](std::size_t t) { return scales.is_large(mesh, t, false); });
}

void open_up(TriangleMesh& mesh, const std::vector<SpannedOpening>& openings) {
  for (std::vector<SpannedOpening> more = openings.empty() ? bridges(mesh) : openings; !more.empty();
       more = bridges(mesh)) {
    std::vector<bool> dropped(mesh.triangles.size(), false);
    for (const SpannedOpening& opening : more) {
      for (const std::uint32_t t : opening.triangles) dropped[t] = true;
    }
    while (drop(mesh, dropped) > 0) dropped = in_smaller_fans(mesh);
  }
}

std::size_t peel_slivers(TriangleMesh& mesh) {
  const HalfEdges half_edges(mesh.triangles, mesh.positions.size());
  const Scales scales(mesh);
  std::vector<bool> dropped(mesh.triangles.size(), false);
  std::vector<bool> on_rim = rim_of(mesh, half_edges);
  const auto corner = [&](HalfEdgeIndex h) { return mesh.triangles[h / 3].at(h % 3); };
  const auto length2 = [&](HalfEdgeIndex h) { return squared_length(mesh, corner(h), corner(HalfEdges::next(h))); };
  std::vector<HalfEdgeIndex> rim;
  for (std::size_t h = 0; h < 3 * mesh.triangles.size(); ++h) {
    if (half_edges.uses(half_edges.edge_of(HalfEdgeIndex(h))) == 1) rim.emplace_back(h);
  }
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const HalfEdgeIndex h = rim[i];
    const std::array others{HalfEdges::next(h), HalfEdges::previous(h)};
    const VertexIndex opposite = corner(others[1]);
    if (dropped[h / 3] || on_rim[opposite] || !scales.is_large(mesh, h / 3, true)) continue;
    if (length2(h) < std::max(length2(others[0]), length2(others[1]))) continue;
    dropped[h / 3] = true;
    on_rim[opposite] = true;
    for (const HalfEdgeIndex other : others) rim.push_back(half_edges.mate(other));
  }
  return drop(mesh, dropped);
}

}  // namespace surfaced
