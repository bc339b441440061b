// SPDX-License-Identifier: GPL-3.0-or-later
#include "front/closing.hpp"

#include <algorithm>

#include "hole_filling/hole_filling.hpp"

namespace surfaced::front {
namespace {

/// Follows the open edges from e around the hole. Empty if the rim is too long, meets a vertex twice or does not
/// begin at its least vertex.
Rim rim_from(const Fans& fans, const Places& places, Edge e, std::size_t longest) {
  Rim rim;
  for (Edge at = e;;) {
    if (at.from < e.from || rim.size() == longest) return {};
    if (std::ranges::find(rim, at.from) != rim.end()) return {};
    rim.push_back(at.from);
    at = next_open(fans, places, at);
    if (at == e) return rim;
    if (rim.size() > 1 && at.from == e.from) return {};
  }
}

bool is_open(const Fans& fans, Edge e) { return fans.uses({e.to, e.from}) && !fans.uses(e); }

}  // namespace

std::vector<Rim> rims_at(const Fans& fans, const Places& places, std::span<const std::uint32_t> vertices,
                         std::size_t longest) {
  std::vector<Rim> rims;
  std::vector<Edge> edges;
  for (const std::uint32_t v : vertices) {
    edges.clear();
    open_edges(fans, v, edges);
    for (const Edge& e : edges) {
      if (e.from != v) continue;
      Rim rim = rim_from(fans, places, e, longest);
      if (rim.size() >= 3) rims.push_back(std::move(rim));
    }
  }
  return rims;
}

bool close_rim(Fans& fans, Places& places, const Rim& rim, double least_cosine) {
  Loop loop;
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const Edge e{rim[i], rim[i + 1 < rim.size() ? i + 1 : 0]};
    if (!is_open(fans, e)) return false;
    loop.corners.push_back(places.position(e.from));
    loop.beyond.push_back(places.position(fans.apex({e.to, e.from})));
  }
  const auto may_join = [&](std::size_t i, std::size_t j) {
    return !fans.uses({rim[i], rim[j]}) && !fans.uses({rim[j], rim[i]}) && places.short_enough(rim[i], rim[j]);
  };
  const auto triangles = triangulate_loop(loop, {least_cosine, may_join});
  if (!triangles) return false;
  const std::size_t before = fans.mark();
  for (const auto& t : *triangles) fans.add({rim[t[0]], rim[t[1]], rim[t[2]]});
  for (const std::uint32_t v : rim) {
    if (fans.fans(v) == 1 && (fans.around(v) != Around::closed || fans.wedges(v).size() >= 3)) continue;
    if (fans.around(v) == Around::open && fans.wedges(v).size() >= 3) continue;  // other fans wait for their own holes
    fans.undo(before);
    return false;
  }
  return true;
}

std::size_t close_holes(Fans& fans, Places& places, std::span<const std::uint32_t> vertices,
                        const ClosingLimits& limits) {
  std::size_t closed = 0;
  for (const Rim& rim : rims_at(fans, places, vertices, limits.longest)) {
    if (close_rim(fans, places, rim, limits.least_cosine)) ++closed;
  }
  return closed;
}

}  // namespace surfaced::front
