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
/// Corners are numbered 4c+i in 32 bits.
constexpr std::size_t kMostCells = Index<void>::kNone / 4;

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

/// The canonical place of every raw cell: cells ascend by their sorted vertices. Counting sort by the least
/// vertex, then a comparison sort within the few cells that share it.
std::vector<std::uint32_t> canonical_order(const RawTriangulation& raw, std::size_t points, unsigned threads) {
  const std::size_t cells = raw.vertices.size() / 4;
  std::vector<std::uint32_t> starts(points + 1, 0);
  const auto least = [&](std::size_t c) { return *std::min_element(&raw.vertices[4 * c], &raw.vertices[4 * c] + 4); };
  for (std::size_t c = 0; c < cells; ++c) ++starts[least(c) + 1];
  for (std::size_t v = 0; v < points; ++v) starts[v + 1] += starts[v];
  std::vector<std::uint32_t> order(cells);
  for (std::size_t c = 0; c < cells; ++c) order[starts[least(c)]++] = static_cast<std::uint32_t>(c);
  parallel_ranges(threads, points, [&](std::size_t begin, std::size_t end) {
    std::vector<std::pair<Tuple, std::uint32_t>> bucket;
    for (std::size_t v = begin; v < end; ++v) {
      const std::size_t first = v == 0 ? 0 : starts[v - 1];
      bucket.clear();
      for (std::size_t k = first; k < starts[v]; ++k) {
        Tuple tuple{};
        std::copy_n(&raw.vertices[4 * std::size_t{order[k]}], 4, tuple.begin());
        std::array<std::uint8_t, 4> unused{};
        sort_cell(tuple, unused);
        bucket.emplace_back(tuple, order[k]);
      }
      std::ranges::sort(bucket);
      for (std::size_t k = first; k < starts[v]; ++k) order[k] = bucket[k - first].second;
    }
  });
  return order;
}

/// Writes cells and mates in canonical order.
void place_cells(const RawTriangulation& raw, unsigned threads, DelaunayComplex& complex) {
  const std::size_t cells = raw.vertices.size() / 4;
  const std::vector<std::uint32_t> order = canonical_order(raw, complex.points(), threads);
  std::vector<std::uint32_t> place(cells);
  complex.vertices.resize(4 * cells);
  complex.mirrored.resize(cells);
  // Where vertex slot i of a raw cell went, two bits each.
  std::vector<std::uint8_t> sorted_slot(cells);
  parallel_ranges(threads, cells, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Tuple tuple{};
      std::copy_n(&raw.vertices[4 * std::size_t{order[c]}], 4, tuple.begin());
      std::array<std::uint8_t, 4> slots{0, 1, 2, 3};
      complex.mirrored[c] = sort_cell(tuple, slots) ? 1 : 0;
      unsigned packed = 0;
      for (unsigned i = 0; i < 4; ++i) {
        complex.vertices[4 * c + i] = VertexIndex(tuple[i]);
        packed |= i << (2U * slots[i]);
      }
      place[order[c]] = static_cast<std::uint32_t>(c);
      sorted_slot[order[c]] = static_cast<std::uint8_t>(packed);
    }
  });
  complex.mates.resize(4 * cells);
  parallel_ranges(threads, cells, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const std::size_t r = order[c];
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t other = raw.neighbours[4 * r + i];
        std::size_t j = 0;
        while (raw.neighbours[4 * other + j] != r) ++j;
        const auto side = [&](std::size_t cell, std::size_t k) {
          return SideIndex(4 * std::size_t{place[cell]} + ((sorted_slot[cell] >> (2 * k)) & 3U));
        };
        complex.mates[side(r, i)] = side(other, j);
      }
    }
  });
}

void build_stars(DelaunayComplex& complex) {
  complex.star_starts.assign(complex.points() + 2, 0);
  for (const VertexIndex v : complex.vertices) ++complex.star_starts[v + 1];
  for (std::size_t v = 0; v + 1 < complex.star_starts.size(); ++v) complex.star_starts[v + 1] += complex.star_starts[v];
  complex.stars.resize(complex.star_starts[complex.points()]);
  std::vector<std::uint32_t> cursor(complex.star_starts.begin(), complex.star_starts.end() - 2);
  for (std::size_t s = 0; s < complex.vertices.size(); ++s) {
    const VertexIndex v = complex.vertices[s];
    if (v < complex.points()) complex.stars[cursor[v]++] = SideIndex(s);
  }
  complex.star_starts.pop_back();
}

Error flat_error(int dimension, std::size_t points) {
  const std::string count = std::to_string(points) + " distinct points";
  if (dimension == 2)
    return {ErrorCode::coplanar, "all " + count + " lie in one plane; a closed surface needs a volume"};
  return {ErrorCode::collinear, "all " + count + " lie on one line; a closed surface needs a volume"};
}

Result<DelaunayComplex> triangulate_and_flatten(const PointCloud& cloud, Context& context, double until,
                                                Triangulator triangulate) {
  DelaunayComplex complex;
  complex.positions = cloud.positions;
  complex.scale = scale_exactly(complex.positions);
  context.enter("delaunay", until * 3 / 4);
  Result<RawTriangulation> raw = triangulate(complex.positions, context);
  if (!raw) return std::move(raw).error();
  if (raw->dimension < 3) return flat_error(raw->dimension, cloud.size());
  if (raw->vertices.size() / 4 > kMostCells) {
    return Error{ErrorCode::too_many_points, std::to_string(raw->vertices.size() / 4) +
                                                 " Delaunay cells; the limit is " + std::to_string(kMostCells)};
  }
  context.enter("flatten", until);
  place_cells(*raw, context.threads(), complex);
  *raw = {};
  build_stars(complex);
  return complex;
}

}  // namespace

EdgeNumbering number_edges(const DelaunayComplex& complex) {
  EdgeNumbering numbering;
  numbering.edge_of.resize(6 * complex.cells());
  for (std::size_t slot = 0; slot < numbering.edge_of.size(); ++slot) {
    if (numbering.edge_of[slot].valid()) continue;
    const EdgeIndex edge(numbering.slot_of.size());
    numbering.slot_of.push_back(static_cast<std::uint32_t>(slot));
    const std::size_t cell = slot / 6;
    const auto [a, b] = kCellEdges[slot % 6];
    const VertexIndex va = complex.vertices[4 * cell + a];
    const VertexIndex vb = complex.vertices[4 * cell + b];
    for (EdgeWalk walk(complex, CellIndex(cell), a, b);; walk.advance()) {
      const std::size_t base = 4 * walk.cell();
      for (std::size_t k = 0; k < 6; ++k) {
        if (complex.vertices[base + kCellEdges[k][0]] != va || complex.vertices[base + kCellEdges[k][1]] != vb)
          continue;
        numbering.edge_of[6 * walk.cell() + k] = edge;
      }
      if (complex.neighbour(walk.exit()) == cell) break;
    }
  }
  return numbering;
}

Result<DelaunayComplex> delaunay_complex(const PointCloud& cloud, Context& context, double until,
                                         Triangulator triangulate) {
  if (cloud.size() < kFewestPoints) {
    return Error{ErrorCode::too_few_points, std::to_string(cloud.size()) + " distinct points; a closed surface needs " +
                                                std::to_string(kFewestPoints)};
  }
  try {
    return triangulate_and_flatten(cloud, context, until, triangulate);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory,
                 "no memory left for the Delaunay complex of " + std::to_string(cloud.size()) + " points"};
  }
}

}  // namespace surfaced
