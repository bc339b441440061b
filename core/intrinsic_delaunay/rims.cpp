// SPDX-License-Identifier: GPL-3.0-or-later
#include "intrinsic_delaunay/rims.hpp"

#include <algorithm>
#include <queue>
#include <tuple>

namespace surfaced::idt {

using front::Around;
using front::Edge;
using front::Face;
using front::Fans;
using front::kNoVertex;
using front::Places;

namespace {

/// A face (from, to, apex) whose edge from -> to is a rim's.
struct RimFace {
  double diameter;
  Face face;
  friend bool operator<(const RimFace& a, const RimFace& b) {
    return a.diameter != b.diameter ? a.diameter < b.diameter : a.face > b.face;
  }
};

std::optional<RimFace> rim_face(const Fans& fans, Places& places, Edge e) {
  const std::uint32_t apex = fans.apex(e);
  if (apex == kNoVertex || fans.uses({e.to, e.from}) || fans.around(apex) != Around::closed) return std::nullopt;
  const Face face{e.from, e.to, apex};
  const double diameter = 2 * circumradius(places, face);
  if (places.within_longest(diameter, e.from) || places.within_longest(diameter, e.to)) return std::nullopt;
  return RimFace{diameter, face};
}

}  // namespace

std::size_t peel_rims(Fans& fans, Places& places) {
  std::priority_queue<RimFace> waiting;
  const auto consider = [&](Edge e) {
    if (const auto found = rim_face(fans, places, e)) waiting.push(*found);
  };
  std::vector<Edge> open;
  for (const std::uint32_t v : fans.unsettled()) {
    open.clear();
    open_edges(fans, v, open);
    // Open edges are given in the direction of the missing face.
    for (const Edge& e : open) {
      if (e.from == v) consider({e.to, e.from});
    }
  }
  std::size_t peeled = 0;
  while (!waiting.empty()) {
    const Face f = waiting.top().face;
    waiting.pop();
    if (!rim_face(fans, places, {f[0], f[1]})) continue;
    fans.remove(f);
    ++peeled;
    consider({f[2], f[1]});
    consider({f[0], f[2]});
  }
  return peeled;
}

}  // namespace surfaced::idt
