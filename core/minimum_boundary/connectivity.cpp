// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/connectivity.hpp"

#include <algorithm>
#include <bit>

#include "base/union_find.hpp"

namespace surfaced::boundary {
namespace {

bool on_surface(const Labelling& labels, VertexIndex v) {
  return std::ranges::any_of(labels.complex().star(v), [&](SideIndex corner) {
    return (labels.border(DelaunayComplex::cell_of(corner)) & ~(1U << (corner % 4))) != 0;
  });
}

}  // namespace

std::size_t SurfaceSearch::components(const Labelling& labels, std::span<const VertexIndex> vertices) {
  const DelaunayComplex& complex = labels.complex();
  if (++now_ == 0) {
    std::ranges::fill(epoch_, 0U);
    now_ = 1;
  }
  std::vector<VertexIndex> queue;
  for (const VertexIndex v : vertices) {
    if (v >= complex.points() || epoch_[v] == now_ || !on_surface(labels, v)) continue;
    epoch_[v] = now_;
    source_[v] = static_cast<std::uint32_t>(queue.size());
    queue.push_back(v);
  }
  // A set is a group of sources that have met; `frontier` counts its vertices still in the queue.
  UnionFind sets(queue.size());
  std::vector<std::size_t> frontier(queue.size(), 1);
  std::size_t growing = queue.size();
  std::size_t exhausted = 0;
  for (std::size_t next = 0; next < queue.size() && growing > 1; ++next) {
    const VertexIndex v = queue[next];
    std::uint32_t set = sets.find(source_[v]);
    for (const SideIndex corner : complex.star(v)) {
      const std::size_t cell = corner / 4;
      if (!labels.in(CellIndex(cell))) continue;
      for (unsigned bits = labels.border(CellIndex(cell)) & ~(1U << (corner % 4)); bits != 0; bits &= bits - 1) {
        const auto beyond = static_cast<std::size_t>(std::countr_zero(bits));
        for (std::size_t i = 0; i < 4; ++i) {
          const VertexIndex u = complex.vertex(4 * cell + i);
          if (i == beyond || u == v) continue;
          if (epoch_[u] != now_) {
            epoch_[u] = now_;
            source_[u] = set;
            ++frontier[set];
            queue.push_back(u);
            continue;
          }
          const std::uint32_t other = sets.find(source_[u]);
          if (other == set) continue;
          const std::size_t sum = frontier[set] + frontier[other];
          sets.unite(set, other);
          set = sets.find(set);
          frontier[set] = sum;
          --growing;
        }
      }
    }
    if (--frontier[set] == 0) {
      --growing;
      ++exhausted;
    }
  }
  return growing + exhausted;
}

}  // namespace surfaced::boundary
