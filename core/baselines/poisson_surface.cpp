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
#include <map>
#include <optional>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "base/vectors.hpp"
#include "baselines/watched_kernel.hpp"

namespace surfaced::baselines {
namespace {

using Poisson = CGAL::Poisson_reconstruction_function<WatchedKernel>;
using PoissonCell = Poisson::Triangulation::Cell_handle;
using PoissonCellQuality = CGAL::Poisson_mesh_cell_criteria_3<Poisson::Triangulation>::Cell_quality;

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

namespace surfaced::baselines {
namespace {

using Point = WatchedKernel::Point_3;
using PointVector = std::pair<Point, WatchedKernel::Vector_3>;

/// A vertex or cell that knows when it was made: handles then compare by that and not by address. The mesher keeps bad
/// edges and vertices in sets of handles and takes the least first.
template <class Base>
class Stamped : public Base {
 public:
  using Base::Base;
  using Has_timestamp = CGAL::Tag_true;
  std::size_t time_stamp() const { return stamp_; }
  void set_time_stamp(std::size_t stamp) { stamp_ = stamp; }
  template <class Structure>
  struct Rebind_TDS {
    using Other = Stamped<typename Base::template Rebind_TDS<Structure>::Other>;
  };

 private:
  std::size_t stamp_ = static_cast<std::size_t>(-1);
};

using Traits = CGAL::Robust_circumcenter_traits_3<ExactKernel>;
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
    Watch::check();
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

Poisson solved(const OrientedPoints& points, Context& context) {
  context.enter("poisson-function", 0.5);
  std::vector<PointVector> input;
  input.reserve(points.positions.size());
  for (std::size_t v = 0; v < points.positions.size(); ++v) {
    const Point3& p = points.positions[v];
    const Point3& n = points.normals[v];
    input.emplace_back(Point(p[0], p[1], p[2]), WatchedKernel::Vector_3(n[0], n[1], n[2]));
  }
  std::size_t done = 0;
  const Insertions insertions{&context, &done, input.size()};
  Poisson function(input.begin(), input.end(), CGAL::First_of_pair_property_map<PointVector>(),
                   CGAL::Second_of_pair_property_map<PointVector>(), insertions);
  if (function.tr().dimension() < 3) throw Flat{};
  if (!function.compute_implicit_function(Solver(), insertions)) {
    throw std::runtime_error("its linear system could not be solved");
  }
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

}  // namespace

TriangleMesh poisson_surface(const OrientedPoints& points, const std::vector<std::size_t>& seeds,
                             const SurfaceOptions& options, Context& context) {
  // As in CGAL's poisson_surface_reconstruction_delaunay.
  constexpr double kLeastAngle = 20;
  constexpr double kSphere = 5;
  constexpr double kBisection = 1e-3;
  const Poisson poisson = solved(points, context);
  context.enter("poisson-surface", 0.95);
  Tessellation tessellation;
  Complex complex(tessellation);
  const WatchedFunction function{&poisson, &tessellation, options.most_vertices};
  for (const std::size_t v : seeds) {
    const auto place = on_surface(function, points.positions[v], points.normals[v], options.spacing);
    if (place) tessellation.insert(library_point(*place));
  }
  if (tessellation.number_of_vertices() == 0) throw std::runtime_error("its function has no zero near the points");
  const double radius = kSphere * std::sqrt(poisson.bounding_sphere().squared_radius());
  using Surface = CGAL::Implicit_surface_3<ExactKernel, WatchedFunction>;
  const Surface surface(function, ExactKernel::Sphere_3(poisson.get_inner_point(), radius * radius),
                        kBisection * options.facet_distance / radius);
  const CGAL::Surface_mesh_default_criteria_3<Tessellation> criteria(kLeastAngle, options.facet_radius,
                                                                     options.facet_distance);
  CGAL::make_surface_mesh(complex, surface, criteria, CGAL::Manifold_with_boundary_tag(), 0);
  return triangles_of(complex, function);
}

}  // namespace surfaced::baselines
