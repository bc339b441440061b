// SPDX-License-Identifier: GPL-3.0-or-later
#include "hole_filling/cutting_back.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include "mesh/area_normal.hpp"
#include "mesh/spanning.hpp"

namespace surfaced::filling {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
/// How many edges around a vertex its spacing is looked for.
constexpr int kRings = 3;
/// Circumradii against the usual one: of triangles that go in from a rim, and of those that span a hole.
constexpr double kStretched = 1.2;
constexpr double kSpanning = 1.45;
/// Least area of a span in squares of the usual circumradius, divided by the third power of that, which says how evenly
/// the vertices are spread (0.72 where none is nearer than 0.75 to another, 0.88 at random): 11 and 20, which are seven
/// and eighteen vertices.
constexpr double kSpanArea = 29;
/// So many gaps say themselves how large the largest may be.
constexpr std::size_t kMany = 20;
/// How often the largest of the other gaps may be larger than a span.
constexpr double kByChance = 0.1;
/// Of all triangles, those whose circumradii are usual.
constexpr double kUsualShare = 0.9;

/// The edge of an equilateral triangle with half the area that a vertex has.
double edge_of_area(double area_per_vertex) { return std::sqrt(2 / std::sqrt(3.0) * area_per_vertex); }

double cube(double x) { return x * x * x; }

class Cutting {
 public:
  Cutting(const TriangleMesh& mesh, Spacings& spacings)
      : mesh_(mesh),
        spacings_(spacings),
        half_edges_(mesh.triangles, mesh.positions.size()),
        gone_(mesh.triangles.size(), false),
        on_rim_(mesh.positions.size(), false) {}

  std::vector<Cut> operator()(std::span<const BoundaryLoop> loops, const std::vector<bool>& holes) {
    for (std::size_t h = 0; h < 3 * mesh_.triangles.size(); ++h) {
      if (half_edges_.mate(HalfEdgeIndex(h)).valid()) continue;
      on_rim_[corner(HalfEdgeIndex(h))] = on_rim_[corner(HalfEdges::next(HalfEdgeIndex(h)))] = true;
    }
    for (const Gap& span : spans()) open(span.triangles);
    for (std::size_t i = 0; i < loops.size(); ++i) {
      if (holes[i]) peel({loops[i].behind.begin(), loops[i].behind.end()}, Cut{});
    }
    return std::move(cuts_);
  }

 private:
  VertexIndex corner(HalfEdgeIndex h) const { return mesh_.triangles[h / 3].at(h % 3); }

  double spacing_around(std::size_t t) const {
    double spacing = 0;
    for (const VertexIndex v : mesh_.triangles[t]) spacing = std::max(spacing, spacings_.at(v));
    return spacing;
  }

  bool is_stretched(std::size_t t, double times) const {
    const double limit = times * spacings_.usual_circumradius() * spacing_around(t);
    return limit > 0 && circumradius(mesh_, mesh_.triangles[t]) > limit;
  }

  /// Connected triangles that are stretched.
  struct Gap {
    std::vector<std::uint32_t> triangles;
    /// In squares of the usual circumradius.
    double area = 0;
  };

  std::vector<Gap> gaps() const {
    std::vector<std::uint32_t> large;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      // Cheap: not even against its own corners, at whose areas it has a third.
      if (spacings_.ratio_to_corners(t) < spacings_.usual_circumradius()) continue;
      if (is_stretched(t, kSpanning)) large.push_back(static_cast<std::uint32_t>(t));
    }
    std::vector<Gap> gaps;
    for (std::vector<std::uint32_t>& set : sets_across_edges(mesh_, large)) {
      double area = 0;
      double spacing = 0;
      for (const std::uint32_t t : set) {
        area += norm(area_normal(mesh_, mesh_.triangles[t])) / 2;
        spacing = std::max(spacing, spacing_around(t));
      }
      const double usual = spacings_.usual_circumradius() * spacing;
      gaps.push_back({std::move(set), area / (usual * usual)});
    }
    return gaps;
  }

  /// The gaps that are too large for one of so many.
  std::vector<Gap> spans() const {
    std::vector<Gap> gaps = this->gaps();
    std::vector<double> areas;
    for (const Gap& gap : gaps) areas.push_back(gap.area);
    const double limit =
        std::max(kSpanArea * cube(spacings_.usual_circumradius()), largest_by_chance(std::move(areas)));
    std::erase_if(gaps, [&](const Gap& gap) { return !(gap.area > limit); });
    return gaps;
  }

  /// Between points that lie at random, areas without points are distributed exponentially. The distribution is read
  /// off its median and upper decile.
  static double largest_by_chance(std::vector<double> areas) {
    if (areas.size() < kMany) return 0;
    const auto quantile = [&](double share) {
      const auto at = areas.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(areas.size()));
      std::ranges::nth_element(areas, at);
      return *at;
    };
    constexpr double kMedian = 0.5;
    constexpr double kDecile = 0.9;
    const double median = quantile(kMedian);
    const double mean = (quantile(kDecile) - median) / std::log((1 - kMedian) / (1 - kDecile));
    return median + mean * std::log((1 - kMedian) * static_cast<double>(areas.size()) / kByChance);
  }

  /// Takes the largest triangle of a span away that touches no rim, and what is stretched around it.
  void open(const std::vector<std::uint32_t>& span) {
    const auto radius = [&](std::uint32_t t) { return circumradius(mesh_, mesh_.triangles[t]); };
    const std::uint32_t largest = *std::ranges::max_element(span, {}, radius);
    if (std::ranges::any_of(mesh_.triangles[largest], [&](VertexIndex v) { return on_rim_[v]; })) return;
    Cut cut{.triangles = {}, .spanned = true};
    take(largest, cut);
    std::deque<HalfEdgeIndex> rim;
    for (std::size_t i = 0; i < 3; ++i) rim.push_back(half_edges_.mate(HalfEdgeIndex(3 * std::size_t{largest} + i)));
    peel(std::move(rim), std::move(cut));
  }

  /// A triangle goes if its third corner is on no rim: what is left is a surface around one hole, as before, and every
  /// vertex keeps a triangle.
  void peel(std::deque<HalfEdgeIndex> rim, Cut cut) {
    for (; !rim.empty(); rim.pop_front()) {
      const HalfEdgeIndex h = rim.front();
      if (!h.valid() || gone_[h / 3]) continue;
      const std::array others{HalfEdges::next(h), HalfEdges::previous(h)};
      if (on_rim_[corner(others[1])] || !is_stretched(h / 3, kStretched)) continue;
      take(h / 3, cut);
      for (const HalfEdgeIndex other : others) rim.push_back(half_edges_.mate(other));
    }
    if (!cut.triangles.empty()) cuts_.push_back(std::move(cut));
  }

  void take(std::size_t t, Cut& cut) {
    gone_[t] = true;
    cut.triangles.push_back(static_cast<std::uint32_t>(t));
    for (const VertexIndex v : mesh_.triangles[t]) on_rim_[v] = true;
  }

  const TriangleMesh& mesh_;
  Spacings& spacings_;
  HalfEdges half_edges_;
  std::vector<bool> gone_;
  std::vector<bool> on_rim_;
  std::vector<Cut> cuts_;
};

}  // namespace

Spacings::Spacings(const TriangleMesh& mesh)
    : mesh_(mesh),
      starts_(mesh.positions.size() + 1, 0),
      triangles_(3 * mesh.triangles.size()),
      areas_(mesh.positions.size(), 0),
      known_(mesh.positions.size(), kUnknown),
      seen_(mesh.positions.size(), VertexIndex::kNone) {
  for (const Triangle& t : mesh.triangles) {
    const auto third = static_cast<float>(norm(area_normal(mesh, t)) / 6);
    for (const VertexIndex v : t) {
      ++starts_[v + 1];
      areas_[v] += third;
    }
  }
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) starts_[v + 1] += starts_[v];
  std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const VertexIndex v : mesh.triangles[t]) triangles_[next[v]++] = static_cast<std::uint32_t>(t);
  }
  forget_boundary();
  std::vector<double> ratios;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (const double ratio = ratio_to_corners(t); std::isfinite(ratio)) ratios.push_back(ratio);
  }
  if (ratios.empty()) return;
  const auto at = ratios.begin() + static_cast<std::ptrdiff_t>(kUsualShare * static_cast<double>(ratios.size()));
  std::ranges::nth_element(ratios, at);
  usual_ = *at;
}

void Spacings::forget_boundary() {
  const HalfEdges half_edges(mesh_.triangles, mesh_.positions.size());
  for (std::size_t h = 0; h < triangles_.size(); ++h) {
    if (half_edges.mate(HalfEdgeIndex(h)).valid()) continue;
    const Triangle& t = mesh_.triangles[h / 3];
    areas_[t.at(h % 3)] = areas_[t.at((h + 1) % 3)] = kUnknown;
  }
}

double Spacings::ratio_to_corners(std::size_t t) const {
  double sum = 0;
  double known = 0;
  for (const VertexIndex v : mesh_.triangles[t]) {
    if (!(areas_[v] > 0)) continue;
    sum += areas_[v];
    ++known;
  }
  return known > 0 ? circumradius(mesh_, mesh_.triangles[t]) / edge_of_area(sum / known)
                   : std::numeric_limits<double>::infinity();
}

double Spacings::at(VertexIndex v) {
  if (std::isnan(known_[v])) known_[v] = static_cast<float>(look_around(v));
  return known_[v];
}

double Spacings::look_around(VertexIndex v) {
  std::vector<VertexIndex> reached{v};
  std::vector<float> areas;
  seen_[v] = v.value;
  std::size_t first = 0;
  for (int ring = 0; ring <= kRings; ++ring) {
    const std::size_t last = reached.size();
    for (; first < last; ++first) {
      const VertexIndex u = reached[first];
      if (areas_[u] > 0) areas.push_back(areas_[u]);
      if (ring == kRings) continue;
      for (std::uint32_t i = starts_[u]; i < starts_[u + 1]; ++i) {
        for (const VertexIndex w : mesh_.triangles[triangles_[i]]) {
          if (std::exchange(seen_[w], v.value) != v.value) reached.push_back(w);
        }
      }
    }
  }
  if (areas.empty()) return 0;
  const auto middle = areas.begin() + static_cast<std::ptrdiff_t>(areas.size() / 2);
  std::ranges::nth_element(areas, middle);
  return edge_of_area(*middle);
}

std::vector<Cut> cut_back(const TriangleMesh& mesh, std::span<const BoundaryLoop> loops, const std::vector<bool>& holes,
                          Spacings& spacings) {
  return Cutting(mesh, spacings)(loops, holes);
}

TriangleMesh without(const TriangleMesh& mesh, std::span<const Cut> cuts) {
  std::vector<bool> gone(mesh.triangles.size(), false);
  for (const Cut& cut : cuts) {
    for (const std::uint32_t t : cut.triangles) gone[t] = true;
  }
  TriangleMesh rest{.positions = mesh.positions, .triangles = {}, .normals = mesh.normals, .colors = mesh.colors};
  for (std::size_t t = 0; t < gone.size(); ++t) {
    if (!gone[t]) rest.triangles.push_back(mesh.triangles[t]);
  }
  return rest;
}

}  // namespace surfaced::filling
