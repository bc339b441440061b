// SPDX-License-Identifier: GPL-3.0-or-later
#include "local_delaunay/local_delaunay.hpp"
#include "reconstruction/front_json.hpp"
#include "reconstruction/hole_stage.hpp"
#include "reconstruction/methods.hpp"
#include "reconstruction/openings_stage.hpp"

namespace surfaced {
namespace {

LocalDelaunayParameters local_delaunay_parameters(const Json& json) {
  LocalDelaunayParameters parameters;
  parameters.neighbours = json.at("neighbours").get<std::size_t>();
  if (json.at("star") == "unfolded") parameters.star = LocalDelaunayParameters::Star::unfolded;
  if (json.at("star") == "projected") parameters.star = LocalDelaunayParameters::Star::projected;
  if (json.at("angle") == "projected") parameters.angle = LocalDelaunayParameters::Angle::projected;
  if (json.at("max_edge").is_number()) parameters.max_edge = json.at("max_edge").get<double>();
  if (json.at("seed") == "paper") parameters.seed = LocalDelaunayParameters::Seed::paper;
  if (json.at("fill_holes") == "none") parameters.fill_holes = LocalDelaunayParameters::FillHoles::none;
  return parameters;
}

Result<Reconstruction> run_local_delaunay(const PointCloud& cloud, const Json& parameters, Context& context) {
  Result<LocalDelaunayResult> result = local_delaunay(cloud, local_delaunay_parameters(parameters), context);
  if (!result) return std::move(result).error();
  Reconstruction made{.mesh = std::move(result->mesh),
                      .warnings = std::move(result->warnings),
                      .statistics = statistics_json(result->statistics)};
  run_openings_parameter(made, parameters);
  if (parameters.at("fill_holes") == "all") {
    if (Status filled = run_hole_stage(made, {}, context); !filled) return std::move(filled).error();
  }
  return made;
}

Json star_properties() {
  return Json{
      {"neighbours",
       {{"type", "integer"},
        {"minimum", 8},
        {"maximum", 64},
        {"default", 16},
        {"title", "Nearest neighbours"},
        {"description", "Points that each normal and each local triangulation is taken from; more for noisy clouds."},
        {"x-unit", "points"}}},
      {"star",
       {{"enum", {"restricted", "unfolded", "projected"}},
        {"default", "restricted"},
        {"title", "Layout of the neighbours in the tangent plane"},
        {"description",
         "restricted cuts the Voronoi cell in space, best at creases and thin parts; unfolded keeps distances, "
         "best on smooth scans; projected is the paper's."}}}};
}

Json local_delaunay_properties() {
  Json properties = star_properties();
  properties["angle"] = {{"enum", {"spatial", "projected"}},
                         {"default", "spatial"},
                         {"title", "Angle of the front"},
                         {"description",
                          "Whether a candidate's angle is taken in space or, as in the paper, in the "
                          "plane."}};
  properties["max_edge"] = max_edge_property("auto sets no limit.");
  properties["seed"] = {{"enum", {"triangle", "paper"}},
                        {"default", "triangle"},
                        {"title", "Start of the front"},
                        {"description",
                         "triangle starts from all triangles on which three local triangulations agree; paper from one "
                         "local triangulation per component."}};
  properties["openings"] = openings_property();
  properties["fill_holes"] = fill_holes_property("small");
  return properties;
}

}  // namespace

Method local_delaunay_method() {
  return {.info = {.id = "local-delaunay",
                   .title = "Local Delaunay triangulations",
                   .summary = "Sews the triangles on which the local triangulations of neighbouring points agree; no "
                              "structure in space. For dense scans and very large clouds; keeps large openings.",
                   .source = "H. H. Bíscaro, Efficient reconstruction from scattered points, WSCG 2010",
                   .guarantees = {"The mesh is consistently oriented, edge- and vertex-manifold.",
                                  "Every vertex of the mesh is an input point, save those that fill_holes=all adds.",
                                  "Closed parts face outwards."},
                   .limitations = {"Closedness is reported, not promised.",
                                   "The mesh may intersect itself where parts come closer than the points are dense.",
                                   "Points may stay unused; the report counts them."},
                   .parameters = schema_of(local_delaunay_properties())},
          .interpolates = true,
          .of_a_point = {.seconds = 10e-6, .bytes = 1 << 10},
          .engine = run_local_delaunay};
}

}  // namespace surfaced
