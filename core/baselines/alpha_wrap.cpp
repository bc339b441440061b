// SPDX-License-Identifier: GPL-3.0-or-later
// Source: C. Portaneri, M. Rouxel-Labbé, M. Hemmer, D. Cohen-Steiner, P. Alliez, "Alpha wrapping with an offset",
// ACM Transactions on Graphics 41 (2022), as implemented by CGAL's alpha_wrap_3.
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "baselines/method.hpp"
#include "baselines/watched_kernel.hpp"
#include "preparing/preparing.hpp"

namespace surfaced {
namespace {

using baselines::ExactKernel;
using SurfaceMesh = CGAL::Surface_mesh<ExactKernel::Point_3>;

/// More vertices than any sensible wrap has; what stands between a tiny alpha and the machine's memory.
std::size_t most_vertices(std::size_t points) {
  constexpr std::size_t kAlways = 20'000;
  constexpr std::size_t kPerPoint = 30;
  return kAlways + kPerPoint * points;
}

/// Thrown by a wrap that grows beyond most_vertices.
struct TooManyVertices : std::runtime_error {
  explicit TooManyVertices(std::size_t limit)
      : std::runtime_error("more than " + std::to_string(limit) + " vertices; a larger alpha needs fewer") {}
};

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
    stop_if_cancelled(*context);
  }
  template <class Wrapper, class Point>
  void before_Steiner_point_insertion(const Wrapper& /*wrapper*/, const Point& /*point*/) {
    if (++inserted > limit) throw TooManyVertices(limit);
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

/// Wraps the same points at any alpha.
class Wrapper {
 public:
  Wrapper(const PointCloud& cloud, Context& context)
      : frame_(cloud.positions),
        spacing_(std::max(kLeastSpacing, frame_.to_local(spacing_of(cloud.positions, context.threads())))),
        context_(context) {
    points_.reserve(cloud.size());
    for (const Point3& p : cloud.positions) {
      const Point3 local = frame_.to_local(p);
      points_.emplace_back(local[0], local[1], local[2]);
    }
  }

  AlphaWrapResult wrap(double alpha, double offset) {
    Visitor visitor{.context = &context_, .expected = points_.size(), .limit = most_vertices(points_.size())};
    SurfaceMesh surface;
    CGAL::alpha_wrap_3(points_, alpha * spacing_, offset * spacing_, surface, CGAL::parameters::default_values(),
                       CGAL::parameters::visitor(visitor));
    return {.mesh = flat_mesh(surface, frame_), .alpha = alpha, .offset = offset};
  }

 private:
  /// In the local frame, a millionth of the box: with less the offset is lost in the digits of a double.
  static constexpr double kLeastSpacing = 0x1p-10;

  LocalFrame frame_;
  double spacing_;
  std::vector<ExactKernel::Point_3> points_;
  Context& context_;
};

/// A wrap finer than one there is already; none if it takes too many vertices.
std::optional<AlphaWrapResult> finer(Wrapper& wrapper, double alpha, double offset) {
  try {
    return wrapper.wrap(alpha, offset);
  } catch (const TooManyVertices&) {
    return std::nullopt;
  }
}

/// Finer and finer, as long as the wrap does not leak inside and has not too many vertices.
AlphaWrapResult finest(Wrapper& wrapper, const std::optional<double>& offset) {
  constexpr std::array kAlphas{12.0, 6.0, 3.0};
  constexpr double kLeaks = 0.5;
  const auto offset_for = [&](double alpha) { return offset.value_or(alpha / AlphaWrapParameters::kAlphaPerOffset); };
  AlphaWrapResult best = wrapper.wrap(kAlphas[0], offset_for(kAlphas[0]));
  double volume = std::abs(signed_volume(best.mesh));
  for (std::size_t i = 1; i < kAlphas.size(); ++i) {
    std::optional<AlphaWrapResult> next = finer(wrapper, kAlphas.at(i), offset_for(kAlphas.at(i)));
    if (!next) break;
    const double next_volume = std::abs(signed_volume(next->mesh));
    if (next_volume < kLeaks * volume) break;
    volume = next_volume;
    best = std::move(*next);
  }
  return best;
}

AlphaWrapResult wrapped(const PointCloud& cloud, const AlphaWrapParameters& parameters, Context& context) {
  context.enter("alpha-wrap", 1);
  Wrapper wrapper(cloud, context);
  const auto& [alpha, offset] = parameters;
  AlphaWrapResult result = alpha ? wrapper.wrap(*alpha, offset.value_or(*alpha / AlphaWrapParameters::kAlphaPerOffset))
                                 : finest(wrapper, offset);
  orient_outwards(result.mesh);
  baselines::sort_mesh(result.mesh);
  baselines::carry_attributes(cloud, result.mesh, context.threads());
  return result;
}

}  // namespace

Result<AlphaWrapResult> alpha_wrap(const PointCloud& cloud, const AlphaWrapParameters& parameters, Context& context) {
  constexpr std::size_t kFewestPoints = 3;
  if (Status enough = baselines::check_points(cloud, kFewestPoints, "an alpha wrap"); !enough) {
    return std::move(enough).error();
  }
  return baselines::guarded("alpha wrap", cloud, context,
                            [&]() -> Result<AlphaWrapResult> { return wrapped(cloud, parameters, context); });
}

}  // namespace surfaced
