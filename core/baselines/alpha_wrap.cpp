// Source: C. Portaneri, M. Rouxel-Labbé, M. Hemmer, D. Cohen-Steiner, P. Alliez, "Alpha wrapping with an offset",
// ACM Transactions on Graphics 41 (2022), as implemented by CGAL's alpha_wrap_3.
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <stdexcept>

#include "baselines/method.hpp"
#include "preparing/preparing.hpp"

namespace surfaced {
namespace {

using baselines::ExactKernel;
using SurfaceMesh = CGAL::Surface_mesh<ExactKernel::Point_3>;

/// More vertices than any sensible wrap has; what stands between a tiny alpha and the machine's memory.
std::size_t most_vertices(std::size_t points) {
  constexpr std::size_t kAlways = 200'000;
  constexpr std::size_t kPerPoint = 30;
  return kAlways + kPerPoint * points;
}

/// Called by CGAL while the wrap shrinks.
struct Visitor {
  Context* context;
  std::size_t expected;
  std::size_t limit;
  std::size_t inserted = 0;

  template <class Wrapper>
  void on_alpha_wrapping_begin(const Wrapper& /*wrapper*/) {}
  template <class Wrapper>
  void on_flood_fill_begin(const Wrapper& /*wrapper*/) {}
  template <class Wrapper, class Gate>
  void before_facet_treatment(const Wrapper& /*wrapper*/, const Gate& /*gate*/) {
    baselines::stop_if_cancelled(*context);
  }
  template <class Wrapper, class Point>
  void before_Steiner_point_insertion(const Wrapper& /*wrapper*/, const Point& /*point*/) {
    if (++inserted > limit) {
      throw std::runtime_error("more than " + std::to_string(limit) + " vertices; a larger alpha needs fewer");
    }
    // Saturates, because nobody knows how many vertices a wrap will have.
    const auto done = static_cast<double>(inserted);
    context->report(done / (done + static_cast<double>(expected)));
  }
  template <class Wrapper, class Vertex>
  void after_Steiner_point_insertion(const Wrapper& /*wrapper*/, Vertex /*vertex*/) {}
  template <class Wrapper>
  void on_flood_fill_end(const Wrapper& /*wrapper*/) {}
  template <class Wrapper>
  void on_alpha_wrapping_end(const Wrapper& /*wrapper*/) {}
};

TriangleMesh flat_mesh(const SurfaceMesh& wrap, const LocalFrame& frame) {
  TriangleMesh mesh;
  for (const auto v : wrap.vertices()) {
    const ExactKernel::Point_3& p = wrap.point(v);
    mesh.positions.push_back(frame.to_input({p.x(), p.y(), p.z()}));
  }
  for (const auto f : wrap.faces()) {
    Triangle t;
    std::size_t i = 0;
    for (const auto v : CGAL::vertices_around_face(wrap.halfedge(f), wrap)) t.at(i++) = VertexIndex(v.idx());
    mesh.triangles.push_back(t);
  }
  return mesh;
}

Result<TriangleMesh> wrap(const PointCloud& cloud, const AlphaWrapParameters& parameters, Context& context) {
  context.enter("alpha-wrap", 1);
  const LocalFrame frame(cloud.positions);
  const double spacing = frame.to_local(spacing_of(cloud.positions, context.threads()));
  std::vector<ExactKernel::Point_3> points;
  points.reserve(cloud.size());
  for (const Point3& p : cloud.positions) {
    const Point3 local = frame.to_local(p);
    points.emplace_back(local[0], local[1], local[2]);
  }
  Visitor visitor{.context = &context, .expected = cloud.size(), .limit = most_vertices(cloud.size())};
  SurfaceMesh surface;
  CGAL::alpha_wrap_3(points, parameters.alpha * spacing, parameters.offset * spacing, surface,
                     CGAL::parameters::default_values(), CGAL::parameters::visitor(visitor));
  TriangleMesh mesh = flat_mesh(surface, frame);
  orient_outwards(mesh);
  baselines::sort_mesh(mesh);
  baselines::carry_attributes(cloud, mesh, context.threads());
  return mesh;
}

}  // namespace

Result<TriangleMesh> alpha_wrap(const PointCloud& cloud, const AlphaWrapParameters& parameters, Context& context) {
  constexpr std::size_t kFewestPoints = 3;
  if (Status enough = baselines::check_points(cloud, kFewestPoints, "an alpha wrap"); !enough) {
    return std::move(enough).error();
  }
  return baselines::guarded("alpha wrap", cloud, context, [&] { return wrap(cloud, parameters, context); });
}

}  // namespace surfaced
