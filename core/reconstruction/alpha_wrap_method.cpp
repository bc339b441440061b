#include "baselines/baselines.hpp"
#include "reconstruction/methods.hpp"

namespace surfaced {
namespace {

Result<Reconstruction> run_alpha_wrap(const PointCloud& cloud, const Json& parameters, Context& context) {
  Result<TriangleMesh> mesh =
      alpha_wrap(cloud, {.alpha = parameters.at("alpha"), .offset = parameters.at("offset")}, context);
  if (!mesh) return std::move(mesh).error();
  return Reconstruction{.mesh = std::move(*mesh), .warnings = {}, .statistics = nullptr};
}

Json parameter_properties() {
  return Json{{"alpha",
               {{"type", "number"},
                {"minimum", 0.5},
                {"maximum", 1e6},
                {"default", 4},
                {"title", "Size of the openings that stay closed"},
                {"description",
                 "Larger wraps more coarsely and closes wider gaps; below the widest gap between points the wrap "
                 "leaks inside."},
                {"x-unit", "point spacings"}}},
              {"offset",
               {{"type", "number"},
                {"minimum", 0.02},
                {"maximum", 1e6},
                {"default", 0.5},
                {"title", "Distance of the wrap from the points"},
                {"description", "Larger is smoother and further outside; smaller takes more triangles and time."},
                {"x-unit", "point spacings"}}}};
}

}  // namespace

Method alpha_wrap_method() {
  return {
      .info = {.id = "alpha-wrap",
               .title = "Alpha wrapping (CGAL)",
               .summary = "Shrinks a box around the points until it holds them at a distance. For clouds of any "
                          "quality, with gaps, noise and outliers, where a watertight hull is wanted.",
               .source = "C. Portaneri, M. Rouxel-Labbé, M. Hemmer, D. Cohen-Steiner, P. Alliez, Alpha wrapping with "
                         "an offset, ACM Transactions on Graphics 41 (2022); CGAL, Alpha_wrap_3",
               .guarantees = {"The mesh is closed, oriented outwards, edge- and vertex-manifold, and does not "
                              "intersect itself.",
                              "Every input point is strictly inside.",
                              "Normals and colours are those of the nearest input point."},
               .limitations = {"The vertices are no input points: the surface lies outside, by about the offset.",
                               "An open sheet becomes a thin closed body, wrapped from both sides.",
                               "Outliers are wrapped too; hollows without an opening are filled.",
                               "Detail smaller than alpha is lost."},
               .parameters = schema_of(parameter_properties())},
      .interpolates = false,
      .engine = run_alpha_wrap};
}

}  // namespace surfaced
