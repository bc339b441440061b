// The only file of this room that knows CGAL.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <array>
#include <new>

#include "delaunay/delaunay.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using CellBase =
    CGAL::Triangulation_cell_base_with_info_3<std::uint32_t, Kernel, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_3<VertexBase, CellBase>;
using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, Structure>;

/// One point in 8 goes to an earlier round, one in 64 to the one before, ...
constexpr std::uint64_t kRoundRatio = 8;
constexpr std::size_t kSmallestRound = 64;
constexpr std::size_t kCancelStride = 1024;

/// A fixed scrambling of the index (splitmix64), so that rounds are random but the same in every run.
std::uint64_t scramble(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

/// Biased randomised insertion order (Amenta, Choi, Rote 2003): rounds of growing size, each in the
/// cloud's own Morton order, forwards and backwards in turn. The cloud is sorted already, so this costs no sorting.
std::vector<std::uint32_t> insertion_order(std::size_t count) {
  unsigned rounds = 1;
  for (std::size_t n = count; n > kSmallestRound; n /= kRoundRatio) ++rounds;
  std::vector<std::uint8_t> round_of(count);
  std::vector<std::size_t> starts(rounds + 1, 0);
  for (std::size_t v = 0; v < count; ++v) {
    std::uint64_t bits = scramble(v);
    unsigned round = rounds - 1;
    while (round > 0 && bits % kRoundRatio == 0) {
      --round;
      bits /= kRoundRatio;
    }
    round_of[v] = static_cast<std::uint8_t>(round);
    ++starts[round + 1];
  }
  for (unsigned r = 0; r < rounds; ++r) starts[r + 1] += starts[r];
  std::vector<std::uint32_t> order(count);
  std::vector<std::size_t> low(starts.begin(), starts.end() - 1);
  std::vector<std::size_t> high(starts.begin() + 1, starts.end());
  for (std::size_t v = 0; v < count; ++v) {
    const unsigned r = round_of[v];
    order[r % 2 == 0 ? low[r]++ : --high[r]] = static_cast<std::uint32_t>(v);
  }
  return order;
}

/// Inserts all points; false if cancelled.
bool insert_all(Triangulation& triangulation, std::span<const Point3> points, Context& context) {
  const std::vector<std::uint32_t> order = insertion_order(points.size());
  Triangulation::Cell_handle hint;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k % kCancelStride == 0) {
      if (context.cancelled()) return false;
      context.report(static_cast<double>(k) / static_cast<double>(order.size()));
    }
    const Point3& p = points[order[k]];
    const Triangulation::Vertex_handle v = triangulation.insert(Kernel::Point_3(p[0], p[1], p[2]), hint);
    v->info() = order[k];
    hint = v->cell();
  }
  triangulation.infinite_vertex()->info() = static_cast<std::uint32_t>(points.size());
  return true;
}

RawTriangulation copy_cells(const Triangulation& triangulation) {
  RawTriangulation raw;
  const Structure& structure = triangulation.tds();
  std::uint32_t count = 0;
  for (auto c = structure.cells_begin(); c != structure.cells_end(); ++c) c->info() = count++;
  raw.vertices.resize(4 * std::size_t{count});
  raw.neighbours.resize(4 * std::size_t{count});
  std::size_t slot = 0;
  for (auto c = structure.cells_begin(); c != structure.cells_end(); ++c, slot += 4) {
    for (int i = 0; i < 4; ++i) {
      raw.vertices[slot + static_cast<std::size_t>(i)] = c->vertex(i)->info();
      raw.neighbours[slot + static_cast<std::size_t>(i)] = c->neighbor(i)->info();
    }
  }
  return raw;
}

}  // namespace

Result<RawTriangulation> triangulate_with_cgal(std::span<const Point3> points, Context& context) {
  try {
    Triangulation triangulation;
    if (!insert_all(triangulation, points, context))
      return Error{ErrorCode::cancelled, "cancelled while triangulating"};
    if (triangulation.dimension() < 3) {
      RawTriangulation flat;
      flat.dimension = triangulation.dimension();
      return flat;
    }
    return copy_cells(triangulation);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory,
                 "no memory left while triangulating " + std::to_string(points.size()) + " points"};
  }
}

}  // namespace surfaced
