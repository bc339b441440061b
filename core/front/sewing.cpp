// SPDX-License-Identifier: GPL-3.0-or-later
// Source: paper 2 (Bíscaro 2010), algorithms 1 and 2. FindNewFace needs no triangulation: with nothing behind the edge,
// the Delaunay triangle on it is the one of the largest angle.
#include "front/sewing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace surfaced::front {

/// Cotangent of the angle at c over the edge ab; large where it does not count.
double Front::apex_cotangent(const Point3& a, const Point3& b, const Point3& c, const Point3& up) const {
  Point3 ca = a - c;
  Point3 cb = b - c;
  double area = 0;
  if (places_.angle() == Angle::projected) {
    const double length2 = dot(up, up);
    const auto flat = [&](Point3& p) {
      const double height = dot(p, up) / length2;
      for (std::size_t i = 0; i < 3; ++i) p[i] -= height * up[i];
    };
    flat(ca);
    flat(cb);
  }
  area = norm(cross(ca, cb));
  return area > 0 ? dot(ca, cb) / area : std::numeric_limits<double>::infinity();
}

/// The vertex that sees the open edge under the largest angle, and the edge's place in the queue.
std::optional<Front::Entry> Front::candidate(Edge e) {
  const std::uint32_t behind = fans_.apex({e.to, e.from});
  if (behind == kNoVertex || fans_.uses(e)) return std::nullopt;
  near_.clear();
  for (const std::uint32_t v : {e.from, e.to}) {
    const auto list = among_ == Pass::Among::stars ? places_.star(v) : places_.neighbours(v);
    near_.insert(near_.end(), list.begin(), list.end());
    edges_.clear();
    open_edges(fans_, v, edges_);
    for (const Edge& o : edges_) near_.push_back(o.from == v ? o.to : o.from);
  }
  const Point3 a = places_.position(e.from);
  const Point3 b = places_.position(e.to);
  const Point3 na = places_.normal(e.from);
  const Point3 nb = places_.normal(e.to);
  const Point3 old_normal = area_normal(places_, {e.to, e.from, behind});
  Point3 up{na[0] + nb[0], na[1] + nb[1], na[2] + nb[2]};
  if (!(dot(up, up) > 0)) up = old_normal;
  const Point3 ahead = cross(up, b - a);
  double least = std::numeric_limits<double>::infinity();
  std::uint32_t apex = kNoVertex;
  for (const std::uint32_t c : near_) {
    if (c == e.from || c == e.to || c == behind) continue;
    const Point3 p = places_.position(c);
    if (!(dot(p - a, ahead) > 0)) continue;
    const double cotangent = apex_cotangent(a, b, p, up);
    if (cotangent > least || (cotangent == least && c >= apex)) continue;
    if (fans_.around(c) == Around::closed) continue;
    if (!places_.short_enough(e.from, c) || !places_.short_enough(e.to, c)) continue;
    if (!places_.in_capsule(e.from, e.to, c)) continue;
    least = cotangent;
    apex = c;
  }
  if (apex == kNoVertex) return std::nullopt;
  const Face face{e.from, e.to, apex};
  const double bend = 1 - cosine(area_normal(places_, face), old_normal);
  const double key = circumradius(places_, face) * (1 + 2 * bend * bend);
  // A face without area has no place in the queue.
  if (!std::isfinite(key)) return std::nullopt;
  return Entry{key, e, apex};
}

void Front::consider(Edge e) {
  if (const std::optional<Entry> entry = candidate(e)) queue_.push(*entry);
}

/// Whether the pass takes this kind of face: an unused apex, an ear, or gluing.
bool Front::fits(const Entry& entry, const Pass& pass) const {
  if (pass.glue || fans_.around(entry.apex) == Around::nothing) return true;
  return fans_.uses({entry.apex, entry.edge.to}) || fans_.uses({entry.edge.from, entry.apex});
}

Result<std::size_t> Front::advance(const Pass& pass, Context& context) {
  const std::vector<std::uint32_t> all = fans_.unsettled();
  return advance(pass, all, context);
}

Result<std::size_t> Front::advance(const Pass& pass, std::span<const std::uint32_t> from, Context& context) {
  constexpr std::size_t kStepsBetweenChecks = 4096;
  queue_ = {};
  among_ = pass.among;
  std::vector<Edge> open;
  for (const std::uint32_t v : from) {
    open.clear();
    open_edges(fans_, v, open);
    for (const Edge& e : open) {
      if (e.from == v || !std::ranges::binary_search(from, e.from)) consider(e);
    }
  }
  std::size_t added = 0;
  // The last entry refused, while nothing has changed: an edge is queued once for every face that touched it.
  Entry refused{std::numeric_limits<double>::quiet_NaN(), {}, kNoVertex};
  for (std::size_t steps = 1; !queue_.empty(); ++steps) {
    if (steps % kStepsBetweenChecks == 0 && context.cancelled())
      return Error{ErrorCode::cancelled, "cancelled while the front advanced"};
    const Entry top = queue_.top();
    queue_.pop();
    if (refused.key == top.key && refused.edge == top.edge) continue;
    const std::optional<Entry> now = candidate(top.edge);
    if (!now) continue;
    if (now->apex != top.apex || now->key != top.key) {
      queue_.push(*now);
      continue;
    }
    const Face face{top.edge.from, top.edge.to, top.apex};
    if (!fits(top, pass) || !legal(fans_, places_, face, pass.least_cosine)) {
      refused = top;
      continue;
    }
    refused.key = std::numeric_limits<double>::quiet_NaN();
    fans_.add(face);
    ++added;
    for (const std::uint32_t v : face) {
      open.clear();
      open_edges(fans_, v, open);
      for (const Edge& e : open) consider(e);
    }
  }
  return added;
}

}  // namespace surfaced::front
