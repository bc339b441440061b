// SPDX-License-Identifier: GPL-3.0-or-later
#include "baselines/baselines.hpp"
#include "reconstruction/hole_stage.hpp"
#include "reconstruction/methods.hpp"
#include "reconstruction/openings_stage.hpp"

namespace surfaced {
namespace {

Result<Reconstruction> run_scale_space(const PointCloud& cloud, const Json& parameters, Context& context) {
  Result<TriangleMesh> mesh = scale_space(
      cloud, {.iterations = parameters.at("iterations"), .neighbours = parameters.at("neighbours")}, context);
  if (!mesh) return std::move(mesh).error();
  Reconstruction result{.mesh = std::move(*mesh), .warnings = {}, .statistics = nullptr};
  run_openings_parameter(result, parameters);
  if (Status filled = run_hole_parameter(result, parameters, context); !filled) return std::move(filled).error();
  return result;
}

Json scale_space_properties() {
  return Json{{"iterations",
               {{"type", "integer"},
                {"minimum", 0},
                {"maximum", 100},
                {"default", 4},
                {"title", "Steps of smoothing"},
                {"description", "More steps bridge more noise and close thin parts; 0 is the advancing front alone."},
                {"x-unit", "1"}}},
              {"neighbours",
               {{"type", "integer"},
                {"minimum", 3},
                {"maximum", 1000},
                {"default", 12},
                {"title", "Points in a neighbourhood"},
                {"description", "How many points the ball holds on average over which a step smooths."},
                {"x-unit", "points"}}},
              {"openings", openings_property()},
              {"fill_holes", fill_holes_property("none")}};
}

}  // namespace

Method scale_space_method() {
  return {
      .info = {.id = "scale-space",
               .title = "Scale space (CGAL)",
               .summary = "Smooths the points step by step, meshes the smooth ones by an advancing front and carries "
                          "the triangles back to the input. For dense scans with noise of up to half the spacing.",
               .source = "J. Digne, J.-M. Morel, C.-M. Souzani, C. Lartigue, Scale space meshing of raw data point "
                         "sets, Computer Graphics Forum 30 (2011); CGAL, Scale_space_reconstruction_3",
               .guarantees = {"Every vertex of the mesh is an input point, save those that fill_holes=all adds.",
                              "The triangles are consistently oriented, closed parts outwards."},
               .limitations = {"The noise stays: the vertices are the unsmoothed points.",
                               "Closedness is reported, not promised.",
                               "The mesh may intersect itself, since its points move back after it was made.",
                               "Points may stay unused; the report counts them."},
               .parameters = schema_of(scale_space_properties())},
      .interpolates = true,
      .of_a_point = {.seconds = 100e-6, .bytes = 2 << 10},
      .engine = run_scale_space};
}

}  // namespace surfaced
