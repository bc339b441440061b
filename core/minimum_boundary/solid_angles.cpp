// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/solid_angles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/parallel.hpp"

namespace surfaced::boundary {
namespace {

constexpr double kThin = 0.1;
constexpr double kBuried = 0.8;
/// Of a vertex that is not on the surface; rounding may bring others a little below 0.
constexpr double kNoAngle = -1;

class Umbrellas {
 public:
  explicit Umbrellas(const Labelling& labels) : labels_(labels), complex_(labels.complex()) {}

  /// Share of the sphere around v inside: excess of its inner dihedral angles. -1 if v is not on the surface.
  double inner_share(VertexIndex v) const {
    double angles = 0;
    std::size_t edges = 0;
    for (const SideIndex corner : complex_.star(v)) {
      if (!labels_.in(CellIndex(corner / 4))) continue;
      for (unsigned bits = labels_.border(CellIndex(corner / 4)) & ~(1U << (corner % 4)); bits != 0; bits &= bits - 1) {
        const SideIndex side(corner / 4 * 4 + static_cast<std::size_t>(std::countr_zero(bits)));
        angles += std::numbers::pi - bend(side, v);
        ++edges;
      }
    }
    if (edges == 0) return kNoAngle;
    return (angles - (static_cast<double>(edges) - 2) * std::numbers::pi) / (4 * std::numbers::pi);
  }

 private:
  /// Angle between the normals at the facet's edge from v to the vertex before it, positive where the surface is
  /// convex.
  double bend(SideIndex side, VertexIndex v) const {
    const auto f = complex_.outward_facet(side);
    const auto at = static_cast<std::size_t>(std::ranges::find(f, v) - f.begin());
    const VertexIndex before = f[(at + 2) % 3];
    const SideIndex next = beyond(side, f[(at + 1) % 3]);
    const Point3 m = normal(side);
    const Point3 n = normal(next);
    const Point3 across = cross(m, n);
    // The facet runs from `before` to v along the edge.
    const Point3 along = complex_.positions[v] - complex_.positions[before];
    const double size = norm(across);
    const double sine = dot(across, along) < 0 ? -size : size;
    const double cosine = dot(m, n);
    const double scale = size + std::abs(cosine);
    if (scale == 0) return 0;
    return static_cast<double>(std::atan2(static_cast<float>(sine / scale), static_cast<float>(cosine / scale)));
  }

  /// The surface facet over the edge opposite `behind`, seen from the same label.
  SideIndex beyond(SideIndex side, VertexIndex behind) const {
    for (SideIndex entry = side;;) {
      std::size_t exit = entry / 4 * 4;
      while (complex_.vertex(exit) != behind) ++exit;
      if (labels_.on_border(SideIndex(exit))) return SideIndex(exit);
      behind = complex_.vertex(entry);
      entry = complex_.mate(exit);
    }
  }

  Point3 normal(SideIndex s) const {
    const auto [a, b, c] = complex_.outward_facet(s);
    return cross(complex_.positions[b] - complex_.positions[a], complex_.positions[c] - complex_.positions[a]);
  }

  const Labelling& labels_;
  const DelaunayComplex& complex_;
};

}  // namespace

SolidAngles solid_angles(const Labelling& labels, unsigned threads) {
  const Umbrellas umbrellas(labels);
  enum Kind : std::uint8_t { kOff, kOrdinary, kThinHere, kBuriedHere };
  std::vector<std::uint8_t> kinds(labels.complex().points(), kOff);
  parallel_ranges(threads, kinds.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const double share = umbrellas.inner_share(VertexIndex(v));
      if (share > kNoAngle) kinds[v] = share < kThin ? kThinHere : share > kBuried ? kBuriedHere : kOrdinary;
    }
  });
  SolidAngles result;
  for (const std::uint8_t kind : kinds) {
    result.vertices += kind == kOff ? 0U : 1U;
    result.thin += kind == kThinHere ? 1U : 0U;
    result.buried += kind == kBuriedHere ? 1U : 0U;
    result.pointed.push_back(kind == kThinHere || kind == kBuriedHere ? 1 : 0);
  }
  return result;
}

}  // namespace surfaced::boundary
