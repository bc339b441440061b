// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/labelling.hpp"

#include <algorithm>

#include "base/parallel.hpp"

namespace surfaced::boundary {
namespace {

unsigned slot_in(const DelaunayComplex& complex, std::size_t cell, VertexIndex v) {
  unsigned i = 0;
  while (complex.vertex(4 * cell + i) != v) ++i;
  return i;
}

}  // namespace

void Labelling::assign(const std::vector<std::uint8_t>& in, unsigned threads) {
  parallel_ranges(threads, complex_->cells(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      unsigned state = in[c] != 0 ? kIn : 0;
      for (unsigned i = 0; i < 4; ++i) {
        if ((in[c] != 0) != (in[complex_->mate(4 * c + i) / 4] != 0)) state |= 1U << (kBorderShift + i);
      }
      state_[c] = static_cast<std::uint8_t>(state);
    }
  });
}

/// Steps along the surface facets at v: from a facet over one of its edges at v, turning through the cells
/// on the side of `start`, to the next facet, until `start` comes again.
std::size_t Labelling::cycle_length(VertexIndex v, SideIndex start) const {
  const DelaunayComplex& complex = *complex_;
  SideIndex side = start;
  // The facet's vertex that the next step turns about, and the one it leaves behind.
  const std::size_t first = start / 4 * 4;
  std::array<VertexIndex, 2> others;
  std::size_t count = 0;
  for (std::size_t s = first; s < first + 4; ++s) {
    if (s != start && complex.vertex(s) != v) others[count++] = complex.vertex(s);
  }
  auto [pivot, behind] = others;
  const VertexIndex start_pivot = pivot;
  std::size_t length = 0;
  do {
    ++length;
    // Turn about the edge (v, pivot): the way on is the side opposite the facet's third vertex.
    VertexIndex apex = complex.vertex(side);
    SideIndex exit(side / 4 * 4 + slot_in(complex, side / 4, behind));
    while (!on_border(exit)) {
      const SideIndex entry = complex.mate(exit);
      behind = apex;
      apex = complex.vertex(entry);
      exit = SideIndex(entry / 4 * 4 + slot_in(complex, entry / 4, behind));
    }
    side = exit;
    behind = pivot;
    pivot = apex;
  } while (side != start || pivot != start_pivot);
  return length;
}

VertexState Labelling::state(VertexIndex v) const {
  std::size_t facets = 0;
  bool any_in = false;
  bool any_out = false;
  SideIndex start;
  for (const SideIndex corner : complex_->star(v)) {
    const unsigned state = state_[corner / 4];
    if ((state & kIn) == 0) {
      any_out = true;
      continue;
    }
    any_in = true;
    const unsigned at_v = (state >> kBorderShift) & ~(1U << (corner % 4));
    if (at_v == 0) continue;
    facets += static_cast<std::size_t>(std::popcount(at_v));
    start = SideIndex(corner / 4 * 4 + static_cast<std::size_t>(std::countr_zero(at_v)));
  }
  if (!any_in) return VertexState::outside;
  if (!any_out) return VertexState::interior;
  // One cycle on the inner side and one on the outer side that both pass all facets: one umbrella.
  const bool single = cycle_length(v, start) == facets && cycle_length(v, complex_->mate(start)) == facets;
  return single ? VertexState::surface : VertexState::pinched;
}

StarGroups StarCounter::count(const Labelling& labels, VertexIndex v) {
  const DelaunayComplex& complex = labels.complex();
  if (++epoch_ == 0) {
    std::ranges::fill(mark_, 0U);
    epoch_ = 1;
  }
  StarGroups groups;
  for (const SideIndex seed : complex.star(v)) {
    if (mark_[seed / 4] == epoch_) continue;
    ++(labels.in(CellIndex(seed / 4)) ? groups.in : groups.out);
    mark_[seed / 4] = epoch_;
    stack_.assign(1, seed);
    while (!stack_.empty()) {
      const SideIndex corner = stack_.back();
      stack_.pop_back();
      const std::size_t cell = corner / 4;
      for (std::size_t s = 4 * cell; s < 4 * cell + 4; ++s) {
        if (s == corner || labels.on_border(SideIndex(s))) continue;
        const std::size_t next = complex.mate(s) / 4;
        if (mark_[next] == epoch_) continue;
        mark_[next] = epoch_;
        stack_.emplace_back(4 * next + slot_in(complex, next, v));
      }
    }
  }
  return groups;
}

std::vector<VertexState> states_of(const Labelling& labels, unsigned threads) {
  std::vector<VertexState> states(labels.complex().points());
  parallel_ranges(threads, states.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) states[v] = labels.state(VertexIndex(v));
  });
  return states;
}

TriangleMesh surface_of(const Labelling& labels, const PointCloud& cloud) {
  const DelaunayComplex& complex = labels.complex();
  TriangleMesh mesh;
  mesh.positions = cloud.positions;
  mesh.normals = cloud.normals;
  mesh.colors = cloud.colors;
  for (std::size_t c = 0; c < complex.cells(); ++c) {
    if (!labels.in(CellIndex(c)) || labels.border(CellIndex(c)) == 0) continue;
    for (std::size_t s = 4 * c; s < 4 * c + 4; ++s) {
      if (labels.on_border(SideIndex(s))) mesh.triangles.push_back(complex.outward_facet(SideIndex(s)));
    }
  }
  sort_triangles(mesh);
  return mesh;
}

}  // namespace surfaced::boundary
