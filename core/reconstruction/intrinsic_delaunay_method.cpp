// SPDX-License-Identifier: GPL-3.0-or-later
#include "intrinsic_delaunay/intrinsic_delaunay.hpp"

#include "reconstruction/front_json.hpp"
#include "reconstruction/hole_stage.hpp"
#include "reconstruction/methods.hpp"
#include "reconstruction/openings_stage.hpp"
#include "reconstruction/upsampling_stage.hpp"

namespace surfaced {
namespace {

IntrinsicDelaunayParameters intrinsic_delaunay_parameters(const Json& json) {
  IntrinsicDelaunayParameters parameters;
  if (json.at("epsilon").is_number()) parameters.epsilon = json.at("epsilon").get<double>();
  if (json.at("max_edge").is_number()) parameters.max_edge = json.at("max_edge").get<double>();
  if (json.at("fill_holes") == "none") parameters.fill_holes = IntrinsicDelaunayParameters::FillHoles::none;
  return parameters;
}

/// Step 6 once more where holes were filled: a patch knows nothing of the angles beyond its rim.
Status flip_filled(Reconstruction& made, Context& context) {
  if (made.hole_filling.at("filled") == 0) return Done{};
  context.enter("flips", 1);
  const Result<idt::FlipCounts> counts = idt::flip_edges(made.mesh, context);
  if (!counts) return counts.error();
  made.statistics["flips_after_filling"] = counts->flips + counts->exchanges;
  made.statistics["not_flippable"] = counts->not_flippable;
  return Done{};
}

Result<Reconstruction> run_intrinsic_delaunay(const PointCloud& cloud, const Json& parameters, Context& context) {
  Json upsampling = nullptr;
  Result<IntrinsicDelaunayResult> result =
      reconstruct_upsampled(cloud, intrinsic_delaunay_parameters(parameters), parameters, upsampling, context);
  if (!result) return std::move(result).error();
  Json statistics = statistics_json(result->statistics.front);
  statistics["flips"] = result->statistics.flips;
  statistics["exchanges"] = result->statistics.exchanges;
  statistics["not_flippable"] = result->statistics.not_flippable;
  statistics["peeled_faces"] = result->statistics.peeled_faces;
  statistics["upsampling"] = std::move(upsampling);
  Reconstruction made{
      .mesh = std::move(result->mesh), .warnings = std::move(result->warnings), .statistics = std::move(statistics)};
  run_openings_parameter(made, parameters);
  if (parameters.at("fill_holes") == "all") {
    const FillParameters fill{.holes = FillParameters::Holes::all, .rotation = rotation_of(parameters)};
    if (Status filled = run_hole_stage(made, fill, context); !filled) return std::move(filled).error();
    if (Status flipped = flip_filled(made, context); !flipped) return std::move(flipped).error();
  }
  count_large_triangles(made);
  return made;
}

Json intrinsic_delaunay_properties() {
  return Json{
      {"epsilon",
       {{"oneOf", {Json{{"const", "auto"}}, Json{{"type", "number"}, {"exclusiveMinimum", 0}, {"maximum", 1e30}}}},
        {"default", "auto"},
        {"title", "Sampling radius"},
        {"description",
         "A front edge looks for its third vertex among the points within twice this distance of it. auto takes the "
         "distance to the 6th nearest neighbour at each end."},
        {"x-unit", "unit of the input"}}},
      {"max_edge", max_edge_property("auto is 3, except for triangles on which three local triangulations agree.")},
      {"certificate",
       {{"enum", {"yes", "no"}},
        {"default", "yes"},
        {"title", "Certificate"},
        {"description",
         "Estimates curvature and sampling and holds the triangles against the paper's bounds; no leaves that out of "
         "the report, and saves most of the time on large clouds."}}},
      {"upsample", upsample_property()},
      {"openings", openings_property()},
      {"fill_holes", fill_holes_property("small")},
      {"rotation", rotation_property()}};
}

}  // namespace

Method intrinsic_delaunay_method() {
  return {
      .info = {.id = "intrinsic-delaunay",
               .title = "Intrinsic Delaunay triangulation",
               .summary = "Grows a front by largest angles and flips edges towards the Delaunay triangulation of the "
                          "surface itself. For dense, smooth scans whose triangles must be well shaped.",
               .source = "W. Gong, Y.-J. Liu, K. Tang, T. Wu, Approximate Delaunay mesh reconstruction and quality "
                         "estimation from point samples, Journal of Computational and Applied Mathematics 274 "
                         "(2015)",
               .guarantees =
                   {"The mesh is consistently oriented, edge- and vertex-manifold.",
                    "Every vertex of the mesh is an input point, save those that upsample and fill_holes=all add.",
                    "Closed parts face outwards."},
               .limitations = {"Closedness is reported, not promised.",
                               "The mesh may intersect itself where parts come closer than the points are dense.",
                               "Points may stay unused; the report counts them."},
               .parameters = schema_of(intrinsic_delaunay_properties()),
               .makes_cloud = true},
      .interpolates = true,
      .certified = true,
      .of_a_point = {.seconds = 30e-6, .bytes = 1 << 10},
      .engine = run_intrinsic_delaunay};
}

}  // namespace surfaced
