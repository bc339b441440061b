// SPDX-License-Identifier: GPL-3.0-or-later
#include "baselines/baselines.hpp"
#include "reconstruction/hole_stage.hpp"
#include "reconstruction/methods.hpp"
#include "reconstruction/openings_stage.hpp"

namespace surfaced {
namespace {

Result<Reconstruction> run_advancing_front(const PointCloud& cloud, const Json& parameters, Context& context) {
  Result<TriangleMesh> mesh = advancing_front(
      cloud, {.radius_ratio_bound = parameters.at("radius_ratio_bound"), .beta = parameters.at("beta")}, context);
  if (!mesh) return std::move(mesh).error();
  Reconstruction result{.mesh = std::move(*mesh), .warnings = {}, .statistics = nullptr};
  run_openings_parameter(result, parameters);
  if (Status filled = run_hole_parameter(result, parameters, context); !filled) return std::move(filled).error();
  return result;
}

}  // namespace

Method advancing_front_method() {
  return {.info = {.id = "advancing-front",
                   .title = "Advancing front (CGAL)",
                   .summary = "Grows a surface over the facets of the 3-D Delaunay triangulation, most plausible facet "
                              "first. For dense, even, clean clouds; keeps openings where the sampling leaves them.",
                   .source =
                       "D. Cohen-Steiner, F. Da, A greedy Delaunay-based surface reconstruction algorithm, The Visual "
                       "Computer 20 (2004); CGAL, Advancing_front_surface_reconstruction",
                   .guarantees = {"Every vertex of the mesh is an input point, save those that fill_holes=all adds.",
                                  "The triangles are consistently oriented, closed parts outwards."},
                   .limitations = {"Closedness is reported, not promised.",
                                   "Points may stay unused; the report counts them."},
                   .parameters =
                       schema_of(Json{{"radius_ratio_bound",
                                       {{"type", "number"},
                                        {"minimum", 1},
                                        {"maximum", 1e6},
                                        {"default", 5},
                                        {"title", "Bound of the radius ratio"},
                                        {"description",
                                         "Candidates outside the wedge are dropped if their radius is larger than this "
                                         "times the radius of the facet they continue; smaller leaves more openings."},
                                        {"x-unit", "1"}}},
                                      {"beta",
                                       {{"type", "number"},
                                        {"minimum", 0},
                                        {"maximum", 3.141592653589793},
                                        {"default", 0.52},
                                        {"title", "Half the wedge angle"},
                                        {"description", "Half the angle of the wedge in which only the radius counts."},
                                        {"x-unit", "rad"}}},
                                      {"openings", openings_property()},
                                      {"fill_holes", fill_holes_property("none")}})},
          .interpolates = true,
          .of_a_point = {.seconds = 30e-6, .bytes = 2 << 10},
          .engine = run_advancing_front};
}

}  // namespace surfaced
