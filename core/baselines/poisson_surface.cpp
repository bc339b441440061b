// SPDX-License-Identifier: GPL-3.0-or-later
#include "baselines/poisson_surface.hpp"

// Without it the library prints a line to the standard error for every reconstruction; with it the divergence is that
// of the normals as they are instead of one normalised cell by cell.
#define CGAL_DIV_NON_NORMALIZED
#define CGAL_EIGEN3_ENABLED
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Poisson_reconstruction_function.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>
#include <CGAL/property_map.h>

#include <Eigen/IterativeLinearSolvers>
#include <algorithm>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "base/vectors.hpp"
#include "baselines/stamped.hpp"
#include "baselines/watched_kernel.hpp"
#include "preparing/preparing.hpp"

namespace surfaced::baselines {
namespace {

using Poisson = CGAL::Poisson_reconstruction_function<WatchedKernel>;
using PoissonCell = Poisson::Triangulation::Cell_handle;
using PoissonCellQuality = CGAL::Poisson_mesh_cell_criteria_3<Poisson::Triangulation>::Cell_quality;

bool finite(const ExactKernel::Point_3& p) { return is_finite({p.x(), p.y(), p.z()}); }

/// Whether a ball goes through the points: through two any, three if they span a triangle, four if a tetrahedron. What
/// are no points, spheres for instance, is not asked.
template <class... Points>
bool span_a_ball(const Points&... points) {
  if constexpr ((std::is_convertible_v<Points, ExactKernel::Point_3> && ...)) {
    if (!(finite(points) && ...)) return false;
    if constexpr (sizeof...(Points) == 3) return !CGAL::collinear(static_cast<const ExactKernel::Point_3&>(points)...);
    if constexpr (sizeof...(Points) == 4) return !CGAL::coplanar(static_cast<const ExactKernel::Point_3&>(points)...);
  }
  return true;
}

/// Exact arithmetic ends the process by SIGFPE where it divides by zero or meets what is no number.
template <class... Points>
void require_a_ball(const Points&... points) {
  if (span_a_ball(points...)) return;
  throw std::runtime_error("its surface became too thin for its arithmetic; larger facets or sample=grid may help");
}

}  // namespace
}  // namespace surfaced::baselines

/// The queue of cells to refine. CGAL's own, a boost::bimap, puts a cell among others of the same quality by the
/// address of the cell; here the one that came first goes first.
template <>
class CGAL::Double_map<surfaced::baselines::PoissonCell, surfaced::baselines::PoissonCellQuality> {
  using Cell = surfaced::baselines::PoissonCell;
  using Quality = surfaced::baselines::PoissonCellQuality;
  using ByQuality = std::multimap<Quality, Cell>;

 public:
  using size_type = std::size_t;
  bool empty() const { return by_quality_.empty(); }
  size_type size() const { return by_quality_.size(); }
  ByQuality::iterator front() { return by_quality_.begin(); }
  bool insert(const Cell& cell, const Quality& quality) {
    if (by_cell_.count(cell) != 0) return false;
    by_cell_.emplace(cell, by_quality_.emplace(quality, cell));
    return true;
  }
  bool erase(const Cell& cell) {
    const auto found = by_cell_.find(cell);
    if (found == by_cell_.end()) return false;
    by_quality_.erase(found->second);
    by_cell_.erase(found);
    return true;
  }
  void pop_front() { erase(Cell(front()->second)); }

 private:
  ByQuality by_quality_;
  std::unordered_map<Cell, ByQuality::iterator> by_cell_;
};

/// Circumcentres of the cells that are refined, the only ones that the Poisson function asks of its kernel; where
/// rounding is too coarse CGAL's own goes on exactly.
template <class Base>
class CGAL::Robust_filtered_construct_circumcenter_3<surfaced::baselines::WatchedKernel, Base>
    : public CGAL::Robust_filtered_construct_circumcenter_3<surfaced::baselines::TickingKernel, Base> {
  using Unasked = CGAL::Robust_filtered_construct_circumcenter_3<surfaced::baselines::TickingKernel, Base>;

 public:
  using Unasked::Unasked;
  template <class... Points>
  typename Unasked::result_type operator()(const Points&... points) const {
    surfaced::baselines::require_a_ball(points...);
    return Unasked::operator()(points...);
  }
};

/// Radii of the cells that may be refined. The library takes the centre of a cell to be within its sphere and digs from
/// there; of points that differ by last bits the centre is none of these doubles, and the hole that is dug is none:
/// flat cells, or a recursion without end. Such a cell has the radius 0, with which it is never refined.
template <class Base>
class CGAL::Robust_filtered_compute_squared_radius_3<surfaced::baselines::WatchedKernel, Base>
    : public CGAL::Robust_filtered_compute_squared_radius_3<surfaced::baselines::TickingKernel, Base> {
  using Ticking = surfaced::baselines::TickingKernel;
  using Unasked = CGAL::Robust_filtered_compute_squared_radius_3<Ticking, Base>;
  using Point = Ticking::Point_3;

 public:
  using Unasked::Unasked;
  using Unasked::operator();
  double operator()(const Point& p, const Point& q, const Point& r, const Point& s) const {
    if (!surfaced::baselines::span_a_ball(p, q, r, s)) return 0;
    const Ticking kernel;
    const CGAL::Robust_filtered_construct_circumcenter_3<Ticking, Ticking::Construct_circumcenter_3> centre(kernel);
    const bool within = CGAL::side_of_oriented_sphere(p, q, r, s, centre(p, q, r, s)) == CGAL::ON_POSITIVE_SIDE;
    return within ? Unasked::operator()(p, q, r, s) : 0;
  }
};

namespace surfaced::baselines {
namespace {

using Point = WatchedKernel::Point_3;
using PointVector = std::pair<Point, WatchedKernel::Vector_3>;

/// A construction by exact arithmetic.
template <class Construction>
struct Asked : Construction {
  template <class... Points>
  typename Construction::result_type operator()(const Points&... points) const {
    require_a_ball(points...);
    return Construction::operator()(points...);
  }
};

struct Traits : CGAL::Robust_circumcenter_traits_3<ExactKernel> {
  using Robust = CGAL::Robust_circumcenter_traits_3<ExactKernel>;
  using Construct_circumcenter_3 = Asked<Robust::Construct_circumcenter_3>;
  using Compute_squared_radius_3 = Asked<Robust::Compute_squared_radius_3>;
  Construct_circumcenter_3 construct_circumcenter_3_object() const { return {}; }
  Compute_squared_radius_3 compute_squared_radius_3_object() const { return {}; }
};
// Stamped, because the mesher keeps bad edges and vertices in sets of handles and takes the least first.
using TessellationVertex = Stamped<CGAL::Surface_mesh_vertex_base_3<Traits>>;
using TessellationCell =
    Stamped<CGAL::Delaunay_triangulation_cell_base_with_circumcenter_3<Traits, CGAL::Surface_mesh_cell_base_3<Traits>>>;
using Delaunay =
    CGAL::Delaunay_triangulation_3<Traits, CGAL::Triangulation_data_structure_3<TessellationVertex, TessellationCell>>;

/// A Delaunay triangulation whose duals are never points: the mesher knows what to do with a degenerate segment, but
/// ends with an error where two circumcentres coincide.
struct Tessellation : Delaunay {
  using Delaunay::dual;
  CGAL::Object dual(const Facet& facet) const {
    CGAL::Object object = Delaunay::dual(facet);
    const auto* const p = CGAL::object_cast<Traits::Point_3>(&object);
    return p == nullptr ? object : CGAL::make_object(Traits::Segment_3(*p, *p));
  }
};
using Complex = CGAL::Surface_mesh_complex_2_in_triangulation_3<Tessellation>;

/// Jacobi's preconditioner, at which the iterations can be stopped.
class WatchedPreconditioner : public Eigen::DiagonalPreconditioner<double> {
 public:
  using Eigen::DiagonalPreconditioner<double>::DiagonalPreconditioner;
  template <class Rhs>
  auto solve(const Eigen::MatrixBase<Rhs>& b) const {
    Watch::spend(static_cast<std::uint64_t>(b.size()));
    return Eigen::DiagonalPreconditioner<double>::solve(b);
  }
};

/// What Poisson_reconstruction_function asks of a linear solver.
struct Solver {
  using NT = double;
  using Matrix = CGAL::Eigen_sparse_symmetric_matrix<double>;
  using Vector = CGAL::Eigen_vector<double>;

  static bool linear_solver(const Matrix& a, const Vector& b, Vector& x, double& scale) {
    constexpr double kTolerance = 1e-10;
    scale = 1;
    Eigen::ConjugateGradient<Matrix::EigenType, Eigen::Lower, WatchedPreconditioner> solver;
    solver.setTolerance(kTolerance);
    solver.compute(a.eigen_object());
    x = solver.solve(b);
    return solver.info() == Eigen::Success;
  }
};

/// Told of every point that enters the triangulation.
struct Insertions {
  Context* context;
  std::size_t* done;
  std::size_t all;
  void before_insertion() const {
    Watch::tick();
    context->report(static_cast<double>(++*done) / static_cast<double>(all));
  }
};

/// @param around  put beside the points, without a normal.
Poisson solved(const std::vector<PointVector>& input, const std::vector<Point>& around, Context& context) {
  std::size_t done = 0;
  const Insertions insertions{&context, &done, input.size()};
  Poisson function(input.begin(), input.end(), CGAL::First_of_pair_property_map<PointVector>(),
                   CGAL::Second_of_pair_property_map<PointVector>(), insertions);
  if (function.tr().dimension() < 3) throw Flat{};
  // The function gives its triangulation away for reading only, but it is no constant.
  auto& triangulation = const_cast<Poisson::Triangulation&>(function.tr());
  for (const Point& p : around) {
    triangulation.insert({p, CGAL::NULL_VECTOR}, Poisson::Triangulation::STEINER, {}, insertions);
  }
  if (!function.compute_implicit_function(Solver(), insertions)) {
    throw std::runtime_error("its linear system could not be solved");
  }
  return function;
}

/// Whether the triangulation ends somewhere at the points.
bool ends_at_points(const Poisson& function) {
  const Poisson::Triangulation& triangulation = function.tr();
  std::vector<Poisson::Triangulation::Vertex_handle> hull;
  triangulation.adjacent_vertices(triangulation.infinite_vertex(), std::back_inserter(hull));
  return std::ranges::any_of(hull, [](const auto& v) { return v->type() == Poisson::Triangulation::INPUT; });
}

/// The corners of an icosahedron on the sphere up to which the library refines.
std::vector<Point> corners_around(const Poisson& function) {
  constexpr double kEnlarged = 1.5;  // as in compute_implicit_function
  const auto sphere = function.bounding_sphere();
  const double shorter = kEnlarged * std::sqrt(sphere.squared_radius() / (2 + std::numbers::phi));
  const double longer = std::numbers::phi * shorter;
  std::vector<Point> corners;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double y : {-shorter, shorter}) {
      for (const double z : {-longer, longer}) {
        std::array<double, 3> off{};
        off.at((axis + 1) % 3) = y;
        off.at((axis + 2) % 3) = z;
        corners.push_back(sphere.center() + WatchedKernel::Vector_3(off[0], off[1], off[2]));
      }
    }
  }
  return corners;
}

Poisson solved(const OrientedPoints& points, Context& context) {
  context.enter("poisson-function", 0.5);
  std::vector<PointVector> input;
  input.reserve(points.positions.size());
  for (std::size_t v = 0; v < points.positions.size(); ++v) {
    const Point3& p = points.positions[v];
    const Point3& n = points.normals[v];
    input.emplace_back(Point(p[0], p[1], p[2]), WatchedKernel::Vector_3(n[0], n[1], n[2]));
  }
  Poisson function = solved(input, {}, context);
  // The library adds nothing but circumcentres of bad tetrahedra. Where the points are spread evenly on something
  // convex none of these is outside, and a function that ends at the points is no use.
  if (ends_at_points(function)) return solved(input, corners_around(function), context);
  return function;
}

/// The function as the mesher asks for it; counts what the mesher makes.
struct WatchedFunction {
  using FT = double;
  using Point = ExactKernel::Point_3;

  const Poisson* poisson;
  const Tessellation* tessellation;
  std::size_t most_vertices;

  double operator()(const Point& p) const {
    Watch::tick();
    if (tessellation->number_of_vertices() > most_vertices) {
      throw std::runtime_error("its surface takes more than " + std::to_string(most_vertices) +
                               " vertices; larger facets need fewer");
    }
    return (*poisson)(p);
  }
};

ExactKernel::Point_3 library_point(const Point3& p) { return {p[0], p[1], p[2]}; }

/// The place on the surface nearest to a point along its normal, looked for within some spacings.
std::optional<Point3> on_surface(const WatchedFunction& function, const Point3& p, const Point3& normal,
                                 double spacing) {
  constexpr std::array kReach{0.5, 1.0, 2.0, 4.0};
  constexpr int kHalvings = 30;
  const auto value = [&](double t) { return function(library_point(p + t * normal)); };
  for (const double reach : kReach) {
    double low = -reach * spacing;
    double high = reach * spacing;
    const bool inside = value(low) < 0;
    if ((value(high) < 0) == inside) continue;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = (low + high) / 2;
      ((value(middle) < 0) == inside ? low : high) = middle;
    }
    return p + low * normal;
  }
  return std::nullopt;
}

/// The facets of the complex, each seen from the cell whose circumcentre is outside.
TriangleMesh triangles_of(const Complex& complex, const WatchedFunction& function) {
  const Tessellation& tessellation = complex.triangulation();
  TriangleMesh mesh;
  std::unordered_map<Tessellation::Vertex_handle, std::size_t> number;
  const auto numbered = [&](Tessellation::Vertex_handle v) {
    const auto [found, is_new] = number.emplace(v, mesh.positions.size());
    if (is_new) mesh.positions.push_back({v->point().x(), v->point().y(), v->point().z()});
    return VertexIndex(found->second);
  };
  for (auto each = complex.facets_begin(); each != complex.facets_end(); ++each) {
    Tessellation::Facet facet = *each;
    if (tessellation.is_infinite(facet.first)) facet = tessellation.mirror_facet(facet);
    const auto& [cell, i] = facet;
    Triangle t{numbered(cell->vertex(Tessellation::vertex_triple_index(i, 0))),
               numbered(cell->vertex(Tessellation::vertex_triple_index(i, 1))),
               numbered(cell->vertex(Tessellation::vertex_triple_index(i, 2)))};
    if (function(tessellation.dual(cell)) < 0) std::swap(t[1], t[2]);
    mesh.triangles.push_back(t);
  }
  return mesh;
}

/// As in CGAL's poisson_surface_reconstruction_delaunay.
/// @param places  points of the surface, some on each part.
TriangleMesh meshed(const Poisson& poisson, const std::vector<Point3>& places, const SurfaceOptions& options) {
  constexpr double kLeastAngle = 20;
  constexpr double kSphere = 5;
  constexpr double kBisection = 1e-3;
  Tessellation tessellation;
  Complex complex(tessellation);
  const WatchedFunction function{&poisson, &tessellation, options.most_vertices};
  for (const Point3& place : places) tessellation.insert(library_point(place));
  if (tessellation.dimension() < 3) return {};
  const double radius = kSphere * std::sqrt(poisson.bounding_sphere().squared_radius());
  using Surface = CGAL::Implicit_surface_3<ExactKernel, WatchedFunction>;
  const Surface surface(function, ExactKernel::Sphere_3(poisson.get_inner_point(), radius * radius),
                        kBisection * options.facet_distance / radius);
  const CGAL::Surface_mesh_default_criteria_3<Tessellation> criteria(kLeastAngle, options.facet_radius,
                                                                     options.facet_distance);
  CGAL::make_surface_mesh(complex, surface, criteria, CGAL::Manifold_with_boundary_tag(), 0);
  return triangles_of(complex, function);
}

/// The places that are further than `reach` from all vertices.
std::vector<std::size_t> far_from(const std::vector<Point3>& vertices, const std::vector<Point3>& places, double reach,
                                  unsigned threads) {
  std::vector<std::size_t> far(places.size());
  std::iota(far.begin(), far.end(), std::size_t{0});
  if (vertices.empty()) return far;
  const std::vector<double> distance = nearest_points(vertices, places, threads).distance;
  std::erase_if(far, [&](std::size_t v) { return distance[v] <= reach; });
  return far;
}

/// Where the surface is near the points that are far from all of these vertices, looked for from one point in every
/// cell of a grid.
/// @param cell  in spacings, that of the points that are asked or that of all, whichever is less.
std::vector<Point3> new_places(const Poisson& poisson, const OrientedPoints& points, const TriangleMesh& mesh,
                               const SurfaceOptions& options, double cell, Context& context) {
  // A vertex is nearer than one facet radius to all of the surface around it.
  const double covered = 1.5 * options.facet_radius;
  const std::vector<std::size_t> far =
      far_from(mesh.positions, points.positions, options.facet_radius + options.spacing, context.threads());
  if (far.empty()) return {};
  PointCloud asked;
  for (const std::size_t v : far) asked.positions.push_back(points.positions[v]);
  const double spacing = mesh.positions.empty()
                             ? options.spacing
                             : std::min(options.spacing, spacing_of(asked.positions, context.threads()));
  const Result<PointCloud> sample = sampled(asked, cell * spacing, context);
  if (!sample) {
    stop_if_cancelled(context);
    throw std::runtime_error(sample.error().detail);
  }
  const Tessellation none;
  const WatchedFunction function{&poisson, &none, options.most_vertices};
  std::vector<Point3> found;
  for (const VertexIndex i : nearest_points(asked.positions, sample->positions, context.threads()).index) {
    const auto place = on_surface(function, asked.positions[i], points.normals[far[i]], spacing);
    if (place) found.push_back(*place);
  }
  std::vector<Point3> places;
  for (const std::size_t i : far_from(mesh.positions, found, covered, context.threads())) places.push_back(found[i]);
  return places;
}

}  // namespace

TriangleMesh poisson_surface(const OrientedPoints& points, const SurfaceOptions& options, Context& context) {
  // The mesher follows the surface from facets that it is given, so each part needs a few: coarse cells find large
  // parts, and finer ones what these missed.
  constexpr std::array kCells{8.0, 2.0, 0.5};
  const Poisson poisson = solved(points, context);
  context.enter("poisson-surface", 0.95);
  TriangleMesh mesh;
  for (const double cell : kCells) {
    std::vector<Point3> places = new_places(poisson, points, mesh, options, cell, context);
    if (places.empty()) continue;
    places.insert(places.begin(), mesh.positions.begin(), mesh.positions.end());
    mesh = meshed(poisson, places, options);
  }
  return mesh;
}

}  // namespace surfaced::baselines
