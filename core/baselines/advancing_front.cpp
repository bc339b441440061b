// SPDX-License-Identifier: GPL-3.0-or-later
// Source: D. Cohen-Steiner, F. Da, "A greedy Delaunay-based surface reconstruction algorithm",
// The Visual Computer 20 (2004), as implemented by CGAL's Advancing_front_surface_reconstruction.
#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "base/library_failure.hpp"
#include "baselines/baselines.hpp"
#include "baselines/stamped.hpp"
#include "baselines/watched_kernel.hpp"

namespace surfaced {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

/// Numbers objects in the order in which they are first asked about, on its thread while it lives.
class FirstSeen {
 public:
  FirstSeen() : outer_(current()) { current() = this; }
  ~FirstSeen() { current() = outer_; }
  FirstSeen(const FirstSeen&) = delete;
  FirstSeen& operator=(const FirstSeen&) = delete;

  static std::size_t number(const void* object) {
    auto& numbers = current()->numbers_;
    return numbers.try_emplace(object, numbers.size()).first->second;
  }

 private:
  static FirstSeen*& current() {
    thread_local FirstSeen* first_seen = nullptr;
    return first_seen;
  }

  FirstSeen* outer_;
  std::unordered_map<const void*, std::size_t> numbers_;
};

/// An edge of the front as CGAL queues it: by the plausibility of its candidate. Of equal ones CGAL's own type, a pair,
/// takes the one of lesser address; edges that wait for another attempt are all equal.
template <class Edge>
struct Queued {
  Queued(double plausibility, Edge* edge) : first(plausibility), second(edge), number(FirstSeen::number(edge)) {}
  friend bool operator<(const Queued& a, const Queued& b) {
    return a.first != b.first ? a.first < b.first : a.number < b.number;
  }

  double first;
  Edge* second;
  std::size_t number;
};

template <class Base>
struct FrontVertex : Base {
  using Base::Base;
  using Radius_ptr_type = Queued<typename Base::IO_edge_type>;
  template <class Structure>
  struct Rebind_TDS {
    using Other = FrontVertex<typename Base::template Rebind_TDS<Structure>::Other>;
  };
};

using baselines::Stamped;
// Stamped, because the triangulation names a facet by its cell of lesser handle.
using VertexBase = Stamped<FrontVertex<CGAL::Advancing_front_surface_reconstruction_vertex_base_3<Kernel>>>;
using CellBase = Stamped<CGAL::Advancing_front_surface_reconstruction_cell_base_3<Kernel>>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

constexpr std::size_t kPointsBetweenChecks = 4096;

/// CGAL's own plausibility, with a look at the caller's wish to stop.
struct Plausibility {
  Context* context;
  std::size_t expected_calls;
  mutable std::size_t calls = 0;

  template <class Front, class Cell>
  double operator()(const Front& front, Cell& cell, int facet) const {
    if (++calls % kPointsBetweenChecks == 0) {
      stop_if_cancelled(*context);
      context->report(static_cast<double>(calls) / static_cast<double>(expected_calls));
    }
    return front.smallest_radius_delaunay_sphere(cell, facet);
  }
};

using Reconstruction = CGAL::Advancing_front_surface_reconstruction<Delaunay, Plausibility>;

/// The points scaled by a power of two, which is exact, to extents of about 2^10: CGAL's code compares
/// with absolute thresholds (1e-21 for squared areas) that would make the result depend on the unit.
std::vector<Point> scaled_points(const PointCloud& cloud) {
  constexpr int kExtentExponent = 10;
  const Bounds bounds = bounds_of(cloud.positions);
  const Point3 extent = bounds.high - bounds.low;
  int exponent = 0;
  std::frexp(std::ranges::max(extent), &exponent);
  std::vector<Point> points;
  points.reserve(cloud.size());
  for (const Point3& p : cloud.positions) {
    points.emplace_back(std::ldexp(p[0], kExtentExponent - exponent), std::ldexp(p[1], kExtentExponent - exponent),
                        std::ldexp(p[2], kExtentExponent - exponent));
  }
  return points;
}

void insert_all(Delaunay& delaunay, const std::vector<Point>& points, Context& context) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  using PointMap = CGAL::Pointer_property_map<Point>::const_type;
  CGAL::spatial_sort(order.begin(), order.end(),
                     CGAL::Spatial_sort_traits_adapter_3<Kernel, PointMap>(CGAL::make_property_map(points)));
  Delaunay::Vertex_handle hint;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % kPointsBetweenChecks == 0) {
      stop_if_cancelled(context);
      context.report(static_cast<double>(i) / static_cast<double>(order.size()));
    }
    hint = delaunay.insert(points[order[i]], hint);
    hint->info() = order[i];
  }
}

std::vector<Triangle> triangles_of(const Reconstruction& front) {
  std::vector<std::array<std::size_t, 3>> triples;
  CGAL::write_triple_indices(std::back_inserter(triples), front);
  std::vector<Triangle> triangles;
  triangles.reserve(triples.size());
  for (const auto& t : triples) triangles.push_back({VertexIndex(t[0]), VertexIndex(t[1]), VertexIndex(t[2])});
  return triangles;
}

Result<TriangleMesh> reconstruct(const PointCloud& cloud, const AdvancingFrontParameters& parameters,
                                 Context& context) {
  // About 25 calls per point on the clouds measured; progress only.
  constexpr std::size_t kCallsPerPoint = 25;
  context.enter("delaunay", 0.4);
  const std::vector<Point> points = scaled_points(cloud);
  Delaunay delaunay;
  insert_all(delaunay, points, context);
  if (delaunay.dimension() < 2) {
    return Error{ErrorCode::collinear, "all " + std::to_string(cloud.size()) + " distinct points lie on one line"};
  }
  context.enter("advancing-front", 0.95);
  const FirstSeen order_of_edges;
  Reconstruction front(delaunay, Plausibility{&context, kCallsPerPoint * cloud.size()});
  front.run(parameters.radius_ratio_bound, parameters.beta);
  TriangleMesh mesh{cloud.positions, triangles_of(front), cloud.normals, cloud.colors};
  orient_outwards(mesh);
  sort_triangles(mesh);
  return mesh;
}

}  // namespace

Result<TriangleMesh> advancing_front(const PointCloud& cloud, const AdvancingFrontParameters& parameters,
                                     Context& context) {
  constexpr std::size_t kFewestPoints = 3;
  if (cloud.size() < kFewestPoints) {
    return Error{ErrorCode::too_few_points, std::to_string(cloud.size()) + " distinct points of " +
                                                std::to_string(cloud.input_to_vertex.size()) +
                                                " remain; an advancing front needs 3"};
  }
  try {
    return reconstruct(cloud, parameters, context);
  } catch (const Cancelled&) {
    return Error{ErrorCode::cancelled, "cancelled during the advancing front"};
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "the advancing front over " + std::to_string(cloud.size()) +
                                               " points needs more memory than there is"};
  } catch (const std::exception& failure) {
    return Error{ErrorCode::method_failed, "CGAL's advancing front failed: " + reason_of(failure)};
  }
}

}  // namespace surfaced
