// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/curvature.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/parallel.hpp"
#include "minimum_boundary/descent.hpp"

namespace surfaced::boundary {
namespace {

/// Cells whose bends are summed together, so that the sum does not depend on the number of threads.
constexpr std::size_t kEdgeBlock = 1U << 14U;

class Bending {
 public:
  explicit Bending(Labelling& labels) : labels_(labels), complex_(labels.complex()) {}

  double total(unsigned threads) const {
    std::vector<double> sums((complex_.cells() + kEdgeBlock - 1) / kEdgeBlock, 0);
    parallel_ranges(threads, sums.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) {
        const std::size_t last = std::min(complex_.cells(), (b + 1) * kEdgeBlock);
        for (std::size_t c = b * kEdgeBlock; c < last; ++c) sums[b] += at_cell(CellIndex(c));
      }
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
  }

  /// By how much K falls if the cell is flipped; 0 if it does not fall or the flip is not legal.
  double gain(CellIndex c) const {
    const unsigned border = labels_.border(c);
    if (std::popcount(border) != 2 || complex_.infinite(c) || !flip_is_legal(labels_, c)) return 0;
    const auto i = static_cast<std::size_t>(std::countr_zero(border));
    const auto j = static_cast<std::size_t>(std::bit_width(border)) - 1;
    std::array<Point3, 4> own;
    for (std::size_t k = 0; k < 4; ++k) own[k] = normal(SideIndex(4 * c + k));
    std::array<std::size_t, 2> rest;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (k != i && k != j) rest[count++] = k;
    }
    // Sides i and j share the edge of the rest; after the flip the sides of the rest share the edge from i to j.
    // The edge opposite i and one of the rest belongs to side i now and to the side of that one then; the facet
    // beyond it stays.
    double fall =
        angle(own[i], own[j]) * length(c, rest[0], rest[1]) - angle(own[rest[0]], own[rest[1]]) * length(c, i, j);
    for (const auto& [shown, other] : {std::array{i, j}, std::array{j, i}}) {
      for (std::size_t k = 0; k < 2; ++k) {
        const SideIndex next = beyond(SideIndex(4 * c + shown), complex_.vertex(4 * c + rest[k]));
        // Seen from this cell's side now, hence from the other label: the sense of both normals turns with the flip.
        const Point3 outer = normal(next);
        const Point3 then = own[rest[k]];
        fall +=
            (angle(own[shown], outer) - angle({-then[0], -then[1], -then[2]}, outer)) * length(c, other, rest[1 - k]);
      }
    }
    return std::max(fall, 0.0);
  }

  void flip(CellIndex c) { labels_.flip(c); }

  /// Length of the edge that a flip brings over that of the one it takes.
  double stretch(CellIndex c) const {
    const unsigned border = labels_.border(c);
    const auto i = static_cast<std::size_t>(std::countr_zero(border));
    const auto j = static_cast<std::size_t>(std::bit_width(border)) - 1;
    std::array<std::size_t, 2> rest;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (k != i && k != j) rest[count++] = k;
    }
    return length(c, i, j) / length(c, rest[0], rest[1]);
  }

 private:
  /// Every edge once, at the lesser of the two inner sides that meet at it.
  double at_cell(CellIndex c) const {
    if (!labels_.in(c)) return 0;
    double sum = 0;
    for (unsigned bits = labels_.border(c); bits != 0; bits &= bits - 1) {
      const SideIndex side(4 * c + static_cast<std::size_t>(std::countr_zero(bits)));
      for (std::size_t k = 4 * c; k < 4 * c + 4; ++k) {
        if (k == side) continue;
        const SideIndex next = beyond(side, complex_.vertex(k));
        if (side > next) continue;
        std::array<std::size_t, 2> ends;
        std::size_t count = 0;
        for (std::size_t e = 0; e < 4; ++e) {
          if (e != side % 4 && e != k % 4) ends[count++] = e;
        }
        sum += angle(normal(side), normal(next)) * length(c, ends[0], ends[1]);
      }
    }
    return sum;
  }

  /// The surface facet over the edge opposite v, seen from the same label.
  SideIndex beyond(SideIndex side, VertexIndex v) const {
    VertexIndex behind = v;
    for (SideIndex entry = side;;) {
      std::size_t exit = entry / 4 * 4;
      while (complex_.vertex(exit) != behind) ++exit;
      if (labels_.on_border(SideIndex(exit))) return SideIndex(exit);
      behind = complex_.vertex(entry);
      entry = complex_.mate(exit);
    }
  }

  /// In single precision, which is three times as fast and enough for a percentage.
  static double angle(const Point3& m, const Point3& n) {
    const double across = norm(cross(m, n));
    const double along = dot(m, n);
    const double size = across + std::abs(along);
    if (size == 0) return 0;
    return static_cast<double>(std::atan2(static_cast<float>(across / size), static_cast<float>(along / size)));
  }

  double length(CellIndex c, std::size_t a, std::size_t b) const {
    return norm(complex_.positions[complex_.vertex(4 * c + a)] - complex_.positions[complex_.vertex(4 * c + b)]);
  }

  Point3 normal(SideIndex s) const {
    const auto [a, b, c] = complex_.outward_facet(s);
    return cross(complex_.positions[b] - complex_.positions[a], complex_.positions[c] - complex_.positions[a]);
  }

  Labelling& labels_;
  const DelaunayComplex& complex_;
};

}  // namespace

namespace {

/// Flips the cells, in their order, wherever that lowers K when their turn comes; returns by how much K fell. Leaves in
/// `cells` those that share an edge with a flipped one, ascending.
double flip_in_turn(Labelling& labels, Bending& bending, double stretch, std::vector<CellIndex>& cells,
                    std::size_t& flipped) {
  const DelaunayComplex& complex = labels.complex();
  double removed = 0;
  std::vector<CellIndex> near;
  for (const CellIndex c : cells) {
    const double gain = bending.gain(c);
    if (!(gain > 0) || bending.stretch(c) > stretch) continue;
    bending.flip(c);
    ++flipped;
    removed += gain;
    for (const auto& [a, b] : kCellEdges) {
      EdgeWalk walk(complex, c, a, b);
      do {
        near.push_back(walk.cell());
        walk.advance();
      } while (walk.cell() != c);
    }
  }
  std::ranges::sort(near);
  near.erase(std::unique(near.begin(), near.end()), near.end());
  cells = std::move(near);
  return removed;
}

}  // namespace

Straightened straighten(Labelling& labels, double stretch, unsigned rounds, unsigned threads) {
  Bending bending(labels);
  Straightened result{bending.total(threads)};
  std::vector<std::uint8_t> wanted(labels.complex().cells());
  parallel_ranges(threads, wanted.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) wanted[c] = bending.gain(CellIndex(c)) > 0 ? 1 : 0;
  });
  std::vector<CellIndex> cells;
  for (std::size_t c = 0; c < wanted.size(); ++c) {
    if (wanted[c] != 0) cells.emplace_back(c);
  }
  for (unsigned round = 0; round < rounds && !cells.empty(); ++round) {
    result.removed += flip_in_turn(labels, bending, stretch, cells, result.flipped);
  }
  return result;
}

double curvature_reduction(Labelling labels, unsigned threads) {
  return straighten(labels, INFINITY, 1, threads).percent();
}

}  // namespace surfaced::boundary
