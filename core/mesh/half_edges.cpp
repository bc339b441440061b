// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <numeric>

#include "mesh/mesh.hpp"

namespace surfaced {
namespace {

VertexIndex tail(std::span<const Triangle> triangles, std::size_t h) { return triangles[h / 3][h % 3]; }
VertexIndex head(std::span<const Triangle> triangles, std::size_t h) { return triangles[h / 3][(h % 3 + 1) % 3]; }

struct Slot {
  VertexIndex far;  // the greater end
  std::uint32_t half_edge;
};

/// All half-edges, bucketed by their lesser end; starts[v]..starts[v+1] are the slots of v.
std::vector<Slot> bucket_by_lesser_end(std::span<const Triangle> triangles, std::vector<std::uint32_t>& starts) {
  const std::size_t count = 3 * triangles.size();
  for (std::size_t h = 0; h < count; ++h) ++starts[std::min(tail(triangles, h), head(triangles, h)) + 1];
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  std::vector<std::uint32_t> cursor(starts.begin(), starts.end() - 1);
  std::vector<Slot> slots(count);
  for (std::size_t h = 0; h < count; ++h) {
    const VertexIndex a = tail(triangles, h);
    const VertexIndex b = head(triangles, h);
    slots[cursor[std::min(a, b)]++] = {std::max(a, b), static_cast<std::uint32_t>(h)};
  }
  return slots;
}

}  // namespace

HalfEdges::HalfEdges(std::span<const Triangle> triangles, std::size_t vertices)
    : mate_(3 * triangles.size()), edge_of_(3 * triangles.size()) {
  std::vector<std::uint32_t> starts(vertices + 1, 0);
  std::vector<Slot> slots = bucket_by_lesser_end(triangles, starts);
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto first = slots.begin() + starts[v];
    const auto last = slots.begin() + starts[v + 1];
    std::sort(first, last,
              [](const Slot& a, const Slot& b) { return a.far != b.far ? a.far < b.far : a.half_edge < b.half_edge; });
    for (auto begin = first, end = first; begin != last; begin = end) {
      while (end != last && end->far == begin->far) edge_of_[(end++)->half_edge] = static_cast<std::uint32_t>(edges());
      uses_.push_back(static_cast<std::uint32_t>(end - begin));
      const auto other = begin + 1;
      if (end - begin == 2 && tail(triangles, begin->half_edge) != tail(triangles, other->half_edge)) {
        mate_[begin->half_edge] = HalfEdgeIndex(other->half_edge);
        mate_[other->half_edge] = HalfEdgeIndex(begin->half_edge);
      }
    }
  }
}

}  // namespace surfaced
