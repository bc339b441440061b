// SPDX-License-Identifier: GPL-3.0-or-later
#include "baselines/baselines.hpp"
#include "reconstruction/methods.hpp"

namespace surfaced {
namespace {

Result<Reconstruction> run_poisson(const PointCloud& cloud, const Json& parameters, Context& context) {
  PoissonParameters poisson_parameters{.facet_radius = parameters.at("facet_radius"),
                                       .facet_distance = parameters.at("facet_distance")};
  if (const Json& reach = parameters.at("trim"); reach == "none") {
    poisson_parameters.trim = std::nullopt;
  } else if (reach.is_number()) {
    poisson_parameters.trim = reach.get<double>();
  }
  Result<PoissonResult> poisson_result = poisson(cloud, poisson_parameters, context);
  if (!poisson_result) return std::move(poisson_result).error();
  const std::size_t left_out = poisson_result->points_left_out;
  Reconstruction result{
      .mesh = std::move(poisson_result->mesh), .warnings = {}, .statistics = Json{{"points_left_out", left_out}}};
  if (cloud.normals.empty()) {
    result.warnings.emplace_back(
        "the cloud has no normals: they were estimated, and the highest point of each part was taken to face up");
  }
  if (left_out > 0) {
    result.warnings.push_back(std::to_string(left_out) + " of " + std::to_string(cloud.size()) +
                              " points are further than " +
                              Json(poisson_parameters.facet_radius + PoissonResult::kLeftOut).dump() +
                              " spacings from all vertices: outliers, or parts of which no surface was found");
  }
  return result;
}

Json in_spacings(double minimum, double maximum, double value, const char* title, const char* text) {
  return {{"type", "number"}, {"minimum", minimum},  {"maximum", maximum},        {"default", value},
          {"title", title},   {"description", text}, {"x-unit", "point spacings"}};
}

Json poisson_properties() {
  return Json{
      {"trim",
       {{"oneOf",
         {Json{{"const", "auto"}}, Json{{"const", "none"}},
          Json{{"type", "number"}, {"minimum", 1}, {"maximum", 1e6}}}},
        {"default", "auto"},
        {"title", "Trimming by density"},
        {"description",
         "Drops triangles further than this many point spacings from all points; none keeps the whole closed surface; "
         "auto is 6."},
        {"x-unit", "point spacings"}}},
      {"facet_radius",
       in_spacings(0.25, 100, 2, "Size of the triangles", "Largest radius of the balls around the triangles.")},
      {"facet_distance", in_spacings(0.01, 100, 0.25, "Deviation of the triangles",
                                     "Largest distance of a triangle's centre from the surface of the method.")}};
}

}  // namespace

Method poisson_method() {
  return {
      .info = {.id = "poisson",
               .title = "Poisson reconstruction (CGAL)",
               .summary =
                   "Fits an indicator function to the normals and meshes its zero set, with vertices of its own. "
                   "For noisy scans with or without normals; what has no points near it is trimmed away.",
               .source = "M. Kazhdan, M. Bolitho, H. Hoppe, Poisson surface reconstruction, SGP 2006; CGAL, "
                         "Poisson_surface_reconstruction_3 and Surface_mesher",
               .guarantees = {"The mesh is edge- and vertex-manifold, consistently oriented, outwards.",
                              "Normals and colours are those of the nearest input point.",
                              "Normals are estimated and oriented where the cloud has none."},
               .limitations =
                   {"The vertices are no input points, and sharp edges are rounded.",
                    "Closedness is reported, not promised: trimming opens the mesh where points are missing.",
                    "It is as good as its normals: parts whose normals are turned the wrong way are lost.",
                    "Fewer than 10 points without normals are refused, and all points in one plane. A part of which "
                    "no surface is found is missing, with a warning that counts its points."},
               .parameters = schema_of(poisson_properties())},
      .interpolates = false,
      .of_a_point = {.seconds = 300e-6, .bytes = 6 << 10},
      .engine = run_poisson};
}

}  // namespace surfaced
