// SPDX-License-Identifier: GPL-3.0-or-later
// CGAL's own triangulation, the peer that ours is compared with.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <array>
#include <new>

#include "delaunay/delaunay.hpp"
#include "delaunay/insertion_order.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using CellBase =
    CGAL::Triangulation_cell_base_with_info_3<std::uint32_t, Kernel, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_3<VertexBase, CellBase>;
using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, Structure>;

constexpr std::size_t kCancelStride = 1024;

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
  raw.cells.reserve(count);
  for (auto c = structure.cells_begin(); c != structure.cells_end(); ++c) {
    RawTriangulation::Cell& cell = raw.cells.emplace_back();
    for (int i = 0; i < 4; ++i) {
      const auto slot = static_cast<std::size_t>(i);
      cell.vertices[slot] = c->vertex(i)->info();
      cell.mates[slot] = 4 * c->neighbor(i)->info() + static_cast<std::uint32_t>(c->neighbor(i)->index(c));
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
