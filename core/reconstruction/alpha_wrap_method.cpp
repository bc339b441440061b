// SPDX-License-Identifier: GPL-3.0-or-later
#include <optional>

#include "baselines/baselines.hpp"
#include "reconstruction/methods.hpp"

namespace surfaced {
namespace {

std::optional<double> number_or_auto(const Json& value) {
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

Result<Reconstruction> run_alpha_wrap(const PointCloud& cloud, const Json& parameters, Context& context) {
  Result<AlphaWrapResult> result = alpha_wrap(
      cloud, {.alpha = number_or_auto(parameters.at("alpha")), .offset = number_or_auto(parameters.at("offset"))},
      context);
  if (!result) return std::move(result).error();
  return Reconstruction{.mesh = std::move(result->mesh),
                        .warnings = {},
                        .statistics = Json{{"alpha", result->alpha}, {"offset", result->offset}}};
}

Json spacings(double minimum, const char* title, const char* text) {
  return {{"oneOf", {Json{{"const", "auto"}}, Json{{"type", "number"}, {"minimum", minimum}, {"maximum", 1e6}}}},
          {"default", "auto"},
          {"title", title},
          {"description", text},
          {"x-unit", "point spacings"}};
}

Json alpha_wrap_properties() {
  return Json{{"alpha", spacings(0.5, "Size of the openings that stay closed",
                                 "Larger wraps more coarsely and closes wider gaps; where it is below the widest gap "
                                 "between points the wrap leaks inside. auto is the least of 12, 6 and 3 that does not "
                                 "lose half of its volume.")},
              {"offset", spacings(0.02, "Distance of the wrap from the points",
                                  "Larger is smoother and further outside; smaller takes more triangles and time. auto "
                                  "is a sixth of alpha.")}};
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
               .parameters = schema_of(alpha_wrap_properties())},
      .interpolates = false,
      .of_a_point = {.seconds = 400e-6, .bytes = 3 << 10},
      .engine = run_alpha_wrap};
}

}  // namespace surfaced
