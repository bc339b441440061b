// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/vectors.hpp"
#include "reconstruction/methods.hpp"

namespace surfaced {
namespace {

/// The corners of a box, bit k of a corner's number saying which end of axis k it is at, and its sides, outwards.
TriangleMesh box_between(const Point3& low, const Point3& high) {
  TriangleMesh mesh;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Point3 p{};
    for (unsigned axis = 0; axis < 3; ++axis) p[axis] = (corner >> axis & 1U) != 0 ? high[axis] : low[axis];
    mesh.positions.push_back(p);
  }
  constexpr std::array<std::array<unsigned, 4>, 6> kSides{
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const auto& [a, b, c, d] : kSides) {
    mesh.triangles.push_back({VertexIndex(a), VertexIndex(b), VertexIndex(c)});
    mesh.triangles.push_back({VertexIndex(a), VertexIndex(c), VertexIndex(d)});
  }
  return mesh;
}

Result<Reconstruction> run_box(const PointCloud& cloud, const Json& parameters, Context& context) {
  if (Status begun = context.begin("box", 1); !begun) return std::move(begun).error();
  const Bounds bounds = bounds_of(cloud.positions);
  const Point3 extent = bounds.high - bounds.low;
  for (const double along : extent) {
    if (along == 0) return Error{ErrorCode::coplanar, "all points lie in a plane across an axis; a box needs a volume"};
  }
  const double margin = parameters.at("margin");
  return Reconstruction{.mesh = box_between(bounds.low - margin * extent, bounds.high + margin * extent),
                        .warnings = {},
                        .statistics = Json{{"extent", extent}}};
}

Json box_properties() {
  return Json{{"margin",
               {{"type", "number"},
                {"minimum", 0},
                {"maximum", 10},
                {"default", 0},
                {"title", "Space around the points"},
                {"description", "Added on every side, as a share of the extent along that axis."},
                {"x-unit", "1"}}}};
}

}  // namespace

Method box_method() {
  return {.info = {.id = "box",
                   .title = "Bounding box",
                   .summary = "The box along the axes around a cloud.",
                   .source = "an example",
                   .guarantees = {"The mesh is closed, manifold, oriented outwards, and holds every point."},
                   .limitations = {"Its vertices are no input points."},
                   .parameters = schema_of(box_properties())},
          .interpolates = false,
          .engine = run_box};
}

}  // namespace surfaced
