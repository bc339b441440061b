// SPDX-License-Identifier: GPL-3.0-or-later
// Which faces may be added: the front's tests, in one place.
#include <algorithm>
#include <cmath>

#include "front/sewing.hpp"

namespace surfaced::front {
namespace {

/// Directions in the tangent plane of a vertex as numbers that grow with the angle from a first direction, from 0
/// up to 4; of IEEE operations only.
class Compass {
 public:
  Compass(const Places& places, std::uint32_t v, std::uint32_t first)
      : places_(places), origin_(places.position(v)), normal_(places.normal(v)) {
    const Point3 d = places.position(first) - origin_;
    y_ = cross(normal_, d);
    x_ = cross(y_, normal_);
  }

  double operator()(std::uint32_t w) const {
    const Point3 d = places_.position(w) - origin_;
    const double x = dot(d, x_);
    const double y = dot(d, y_);
    const double sum = std::abs(x) + std::abs(y);
    if (!(sum > 0)) return 0;
    const double turn = 1 - x / sum;
    return y >= 0 ? turn : 4 - turn;
  }

 private:
  const Places& places_;
  Point3 origin_;
  Point3 normal_;
  Point3 x_{};
  Point3 y_{};
};

/// Whether the new wedge would make an umbrella besides other fans, or one of fewer than three faces.
bool closes_wrongly(std::span<const Wedge> wedges, const OpenEnds* open, const Wedge& fresh) {
  // It closes something if a fan begins where it ends and one ends where it begins.
  if (open != nullptr && (std::ranges::find(open->first(), fresh.second) == open->first().end() ||
                          std::ranges::find(open->second(), fresh.first) == open->second().end())) {
    return false;
  }
  const WedgeEnds ends(wedges);
  std::uint32_t end = fresh.second;
  std::size_t faces = 1;
  for (const Wedge* next = ends.from(end); next != nullptr && end != fresh.first; next = ends.from(end)) {
    end = next->second;
    ++faces;
  }
  return end == fresh.first && (faces < 3 || faces != wedges.size() + 1);
}

/// Whether the new wedge lies over existing ones in the tangent plane of v, or spans half of it or more.
bool overlaps(const Places& places, std::uint32_t v, std::span<const Wedge> wedges, const Wedge& fresh) {
  const Compass compass(places, v, fresh.first);
  const double end = compass(fresh.second);
  constexpr double kHalfTurn = 2;
  if (!(end > 0) || end >= kHalfTurn) return true;
  for (const Wedge& w : wedges) {
    const double from = w.first == fresh.second ? end : compass(w.first);
    const double to = w.second == fresh.first ? 0 : compass(w.second);
    if (w.first != fresh.second && from < end) return true;
    if (w.second != fresh.first && to > 0 && to < end) return true;
    if (w.second != fresh.first && to < from) return true;
  }
  return false;
}

bool corner_is_legal(const Fans& fans, const Places& places, std::uint32_t v, const Wedge& fresh) {
  const auto wedges = fans.wedges(v);
  if (wedges.empty()) return true;
  return !closes_wrongly(wedges, fans.open_ends(v), fresh) && !overlaps(places, v, wedges, fresh);
}

}  // namespace

bool legal(const Fans& fans, const Places& places, const Face& face, double least_cosine) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (fans.uses({face[i], face[(i + 1) % 3]}) || fans.around(face[i]) == Around::closed) return false;
  }
  const Point3 normal = area_normal(places, face);
  for (std::size_t i = 0; i < 3; ++i) {
    const Edge back{face[(i + 1) % 3], face[i]};
    const std::uint32_t beyond = fans.apex(back);
    if (beyond == kNoVertex) continue;
    if (beyond == face[(i + 2) % 3]) return false;
    if (cosine(normal, area_normal(places, {back.from, back.to, beyond})) < least_cosine) return false;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (!corner_is_legal(fans, places, face[i], {face[(i + 1) % 3], face[(i + 2) % 3]})) return false;
  }
  return true;
}

void open_edges(const Fans& fans, std::uint32_t v, std::vector<Edge>& edges) {
  if (const OpenEnds* open = fans.open_ends(v)) {
    for (const std::uint32_t end : open->first()) edges.push_back({end, v});
    for (const std::uint32_t end : open->second()) edges.push_back({v, end});
    return;
  }
  const auto wedges = fans.wedges(v);
  const WedgeEnds ends(wedges);
  for (const Wedge& w : wedges) {
    if (ends.to(w.first) == nullptr) edges.push_back({w.first, v});
    if (ends.from(w.second) == nullptr) edges.push_back({v, w.second});
  }
}

Edge next_open(const Fans& fans, const Places& places, Edge e) {
  const Compass compass(places, e.to, e.from);
  std::vector<Edge> open;
  open_edges(fans, e.to, open);
  double best = -1;
  Edge next = e;
  for (const Edge& o : open) {
    if (o.from != e.to) continue;
    const double turn = compass(o.to);
    if (turn <= best) continue;
    best = turn;
    next = o;
  }
  return next;
}

}  // namespace surfaced::front
