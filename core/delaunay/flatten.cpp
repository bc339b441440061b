// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <string>
#include <utility>

#include "base/parallel.hpp"
#include "delaunay/delaunay.hpp"

namespace surfaced {
namespace {

constexpr std::size_t kFewestPoints = 4;

using Tuple = std::array<std::uint32_t, 4>;

/// Scales the positions by the power of two that brings the larger side of the bounding box into [1, 2);
/// leaves them alone where a coordinate would lose bits.
double scale_exactly(std::vector<Point3>& positions) {
  const Bounds bounds = bounds_of(positions);
  double side = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) side = std::max(side, bounds.high[axis] - bounds.low[axis]);
  const int shift = -std::ilogb(side);
  const auto exact = [&](const Point3& p) {
    return std::ranges::all_of(p, [&](double x) { return std::ldexp(std::ldexp(x, shift), -shift) == x; });
  };
  if (!(side > 0) || shift == 0 || !std::ranges::all_of(positions, exact)) return 1;
  const double scale = std::ldexp(1.0, shift);
  if (!std::isnormal(scale)) return 1;
  for (Point3& p : positions) {
    for (double& x : p) x *= scale;
  }
  return scale;
}

/// Sorts the four vertices; returns the parity of the permutation. `slots` follows them.
bool sort_cell(Tuple& v, std::array<std::uint8_t, 4>& slots) {
  bool odd = false;
  const auto order = [&](std::size_t a, std::size_t b) {
    if (v[a] < v[b]) return;
    std::swap(v[a], v[b]);
    std::swap(slots[a], slots[b]);
    odd = !odd;
  };
  order(0, 1);
  order(2, 3);
  order(0, 2);
  order(1, 3);
  order(1, 2);
  return odd;
}

/// A raw cell with its vertices sorted.
struct SortedCell {
  Tuple vertices;
  std::uint32_t raw;
  /// Where vertex slot i of the raw cell went, two bits each.
  std::uint8_t slots;
  std::uint8_t mirrored;
};

SortedCell sorted_cell(const RawTriangulation& raw, std::uint32_t c) {
  SortedCell cell{raw.cells[c].vertices, c, 0, 0};
  std::array<std::uint8_t, 4> from{0, 1, 2, 3};
  cell.mirrored = sort_cell(cell.vertices, from) ? 1 : 0;
  for (unsigned i = 0; i < 4; ++i) cell.slots |= static_cast<std::uint8_t>(i << (2U * from[i]));
  return cell;
}

/// Where the raw cells went.
struct Places {
  struct Place {
    std::uint32_t cell;
    /// As in SortedCell.
    std::uint32_t slots;
  };
  std::vector<std::uint32_t> raw_of;
  std::vector<Place> place_of;

  /// Asks for a raw cell that will be looked at soon, before place `end`: they lie in another order.
  void prefetch(const RawTriangulation& raw, std::size_t place, std::size_t end) const {
    constexpr std::size_t kAhead = 16;
    if (place + kAhead < end) __builtin_prefetch(&raw.cells[raw_of[place + kAhead]]);
  }
};

/// Puts the cells in ascending order of their sorted vertices: counting sort by the least vertex, then a
/// comparison sort of the few cells that share it.
Places place_vertices(const RawTriangulation& raw, unsigned threads, DelaunayComplex& complex) {
  const std::size_t cells = raw.cells.size();
  std::vector<std::uint32_t> starts(complex.points() + 1, 0);
  const auto least = [&](std::size_t c) {
    const auto& [p, q, r, s] = raw.cells[c].vertices;
    return std::min(std::min(p, q), std::min(r, s));
  };
  for (std::size_t c = 0; c < cells; ++c) ++starts[least(c) + 1];
  for (std::size_t v = 0; v < complex.points(); ++v) starts[v + 1] += starts[v];
  Places places{std::vector<std::uint32_t>(cells), std::vector<Places::Place>(cells)};
  for (std::size_t c = 0; c < cells; ++c) places.raw_of[starts[least(c)]++] = static_cast<std::uint32_t>(c);
  complex.table.resize(cells);
  complex.mirrored.resize(cells);
  parallel_ranges(threads, complex.points(), [&](std::size_t begin, std::size_t end) {
    std::vector<SortedCell> bucket;
    for (std::size_t v = begin; v < end; ++v) {
      const std::size_t first = v == 0 ? 0 : starts[v - 1];
      bucket.clear();
      for (std::size_t k = first; k < starts[v]; ++k) {
        places.prefetch(raw, k, starts[end - 1]);
        bucket.push_back(sorted_cell(raw, places.raw_of[k]));
      }
      std::ranges::sort(bucket, {}, &SortedCell::vertices);
      for (std::size_t k = first; k < starts[v]; ++k) {
        const SortedCell& cell = bucket[k - first];
        for (std::size_t i = 0; i < 4; ++i) complex.table[k].vertices[i] = VertexIndex(cell.vertices[i]);
        complex.mirrored[k] = cell.mirrored;
        places.raw_of[k] = cell.raw;
        places.place_of[cell.raw] = {static_cast<std::uint32_t>(k), cell.slots};
      }
    }
  });
  return places;
}

/// Writes cells and mates in canonical order.
void place_cells(const RawTriangulation& raw, unsigned threads, DelaunayComplex& complex) {
  const Places places = place_vertices(raw, threads, complex);
  const auto place = [&](std::size_t side) {
    const Places::Place& at = places.place_of[side / 4];
    return SideIndex(4 * std::size_t{at.cell} + (at.slots >> (2 * (side % 4)) & 3U));
  };
  parallel_ranges(threads, complex.cells(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      places.prefetch(raw, c, end);
      const std::size_t r = places.raw_of[c];
      const std::uint32_t slots = places.place_of[r].slots;
      for (std::size_t i = 0; i < 4; ++i) complex.table[c].mates[slots >> (2 * i) & 3U] = place(raw.cells[r].mates[i]);
    }
  });
}

/// Each of the threads reads all cells and writes the stars of its share of the vertices.
void build_stars(unsigned threads, DelaunayComplex& complex) {
  complex.star_starts.assign(complex.points() + 2, 0);
  const auto for_corners = [&](const auto& body) {
    parallel_tasks(threads, threads, [&](std::size_t part) {
      const std::size_t begin = complex.points() * part / threads;
      const std::size_t end = complex.points() * (part + 1) / threads;
      for (std::size_t c = 0; c < complex.cells(); ++c) {
        for (std::size_t i = 0; i < 4; ++i) {
          const std::size_t v = complex.table[c].vertices[i];
          if (v >= begin && v < end) body(v, SideIndex(4 * c + i));
        }
      }
    });
  };
  // Counted two places ahead: once they are added up, starts[v + 1] is where the star of v begins, and moving
  // it along while that star is filled leaves where the next one begins.
  for_corners([&](std::size_t v, SideIndex) { ++complex.star_starts[v + 2]; });
  for (std::size_t v = 0; v < complex.points(); ++v) complex.star_starts[v + 2] += complex.star_starts[v + 1];
  complex.stars.resize(complex.star_starts.back());
  for_corners([&](std::size_t v, SideIndex corner) { complex.stars[complex.star_starts[v + 1]++] = corner; });
  complex.star_starts.pop_back();
}

Error flat_error(int dimension, std::size_t points) {
  const std::string count = std::to_string(points) + " distinct points";
  if (dimension == 2)
    return {ErrorCode::coplanar, "all " + count + " lie in one plane; a closed surface needs a volume"};
  return {ErrorCode::collinear, "all " + count + " lie on one line; a closed surface needs a volume"};
}

Result<DelaunayComplex> triangulate_and_flatten(const PointCloud& cloud, Context& context, double until,
                                                Triangulator triangulator) {
  DelaunayComplex complex;
  complex.positions = cloud.positions;
  complex.scale = scale_exactly(complex.positions);
  context.enter("delaunay", until * 3 / 4);
  Result<RawTriangulation> raw = triangulator(complex.positions, context);
  if (!raw) return std::move(raw).error();
  if (raw->dimension < 3) return flat_error(raw->dimension, cloud.size());
  if (raw->cells.size() > kMostCells) {
    return Error{ErrorCode::too_many_points,
                 std::to_string(raw->cells.size()) + " Delaunay cells; the limit is " + std::to_string(kMostCells)};
  }
  context.enter("flatten", until);
  place_cells(*raw, context.threads(), complex);
  *raw = {};
  build_stars(context.threads(), complex);
  return complex;
}

}  // namespace

Result<DelaunayComplex> delaunay_complex(const PointCloud& cloud, Context& context, double until,
                                         Triangulator triangulator) {
  if (cloud.size() < kFewestPoints) {
    return Error{ErrorCode::too_few_points, std::to_string(cloud.size()) + " distinct points; a closed surface needs " +
                                                std::to_string(kFewestPoints)};
  }
  try {
    return triangulate_and_flatten(cloud, context, until, triangulator);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory,
                 "no memory left for the Delaunay complex of " + std::to_string(cloud.size()) + " points"};
  }
}

}  // namespace surfaced
