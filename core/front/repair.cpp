// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cstddef>

#include "front/closing.hpp"

namespace surfaced::front {
namespace {

using Vertices = std::vector<std::uint32_t>;

void sort_unique(Vertices& list) {
  std::ranges::sort(list);
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

/// The vertices and those of their faces.
Vertices widened(const Fans& fans, const Vertices& core) {
  Vertices wide = core;
  for (const std::uint32_t v : core) {
    for (const Wedge& w : fans.wedges(v)) wide.insert(wide.end(), {w.first, w.second});
  }
  sort_unique(wide);
  return wide;
}

/// Removes the faces that have at least `corners` vertices in the (sorted) region.
void open_up(Fans& fans, const Vertices& region, std::size_t corners) {
  std::vector<Face> faces;
  for (const std::uint32_t v : region) {
    for (const Wedge& w : fans.wedges(v)) {
      const std::size_t inside = 1 + (std::ranges::binary_search(region, w.first) ? 1U : 0U) +
                                 (std::ranges::binary_search(region, w.second) ? 1U : 0U);
      const bool first = (w.first > v || !std::ranges::binary_search(region, w.first)) &&
                         (w.second > v || !std::ranges::binary_search(region, w.second));
      if (inside >= corners && first) faces.push_back({v, w.first, w.second});
    }
  }
  for (const Face& f : faces) fans.remove(f);
}

std::size_t open_edge_count(const Fans& fans, const Vertices& vertices) {
  std::vector<Edge> edges;
  for (const std::uint32_t v : vertices) open_edges(fans, v, edges);
  return edges.size();
}

/// Which of the vertices have faces.
std::vector<bool> in_use(const Fans& fans, const Vertices& vertices) {
  std::vector<bool> used;
  for (const std::uint32_t v : vertices) used.push_back(fans.around(v) != Around::nothing);
  return used;
}

/// The connected rims at v, as one set of vertices; empty if it is larger than allowed.
Vertices hole_at(const Fans& fans, std::uint32_t v, std::size_t longest) {
  Vertices hole{v};
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < hole.size(); ++i) {
    if (hole.size() > longest) return {};
    edges.clear();
    open_edges(fans, hole[i], edges);
    for (const Edge& e : edges) {
      const std::uint32_t other = e.from == hole[i] ? e.to : e.from;
      if (std::ranges::find(hole, other) == hole.end()) hole.push_back(other);
    }
  }
  sort_unique(hole);
  return hole;
}

/// One attempt: opens, lets the front advance, closes. True if no open edge is left around; else all is as before.
Result<bool> attempt(Fans& fans, Places& places, const Vertices& hole, std::size_t ring, double least_cosine,
                     std::size_t longest, Context& context) {
  const std::size_t before = fans.mark();
  const Vertices region = ring < 2 ? hole : widened(fans, hole);
  const Vertices around = widened(fans, region);
  const std::vector<bool> used = in_use(fans, around);
  open_up(fans, region, ring == 0 ? 2 : 1);
  Front front(fans, places);
  for (const Pass& pass : {Pass{0.5, false}, Pass{std::max(0.0, least_cosine), true}}) {
    if (const auto advanced = front.advance(pass, around, context); !advanced) return advanced.error();
  }
  const Vertices touched = widened(fans, around);
  close_holes(fans, places, touched, {longest, least_cosine});
  const bool closed = open_edge_count(fans, touched) == 0;
  const bool manifold = std::ranges::all_of(touched, [&](std::uint32_t v) { return fans.fans(v) <= 1; });
  // Taking faces away alone would leave no open edge either.
  if (closed && manifold && in_use(fans, around) == used) return true;
  fans.undo(before);
  return false;
}

}  // namespace

Result<std::size_t> repair_holes(Fans& fans, Places& places, std::size_t longest, Context& context) {
  std::size_t closed = 0;
  constexpr std::array kCosines{0.2, -0.3, -0.8};
  constexpr std::size_t kRings = 3;
  for (const std::uint32_t v : fans.unsettled()) {
    if (fans.around(v) != Around::open) continue;
    const Vertices hole = hole_at(fans, v, longest);
    if (hole.empty() || hole.front() != v) continue;
    bool done = false;
    for (const double least_cosine : kCosines) {
      for (std::size_t ring = 0; ring < kRings && !done; ++ring) {
        if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled while holes were repaired"};
        const Result<bool> result = attempt(fans, places, hole, ring, least_cosine, longest, context);
        if (!result) return result.error();
        done = *result;
      }
    }
    if (done) ++closed;
  }
  return closed;
}

std::size_t separate_fans(Fans& fans) {
  std::size_t removed = 0;
  std::vector<std::uint32_t> waiting = fans.unsettled();
  while (!waiting.empty()) {
    const std::uint32_t v = waiting.back();
    waiting.pop_back();
    while (fans.fans(v) > 1) {
      const std::vector<Wedge> smallest = fans.smallest_fan(v);
      for (const Wedge& w : smallest) {
        fans.remove({v, w.first, w.second});
        waiting.insert(waiting.end(), {w.first, w.second});
        ++removed;
      }
    }
  }
  return removed;
}

}  // namespace surfaced::front
