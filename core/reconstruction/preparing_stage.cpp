// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/preparing_stage.hpp"

#include <algorithm>

#include "preparing/preparing.hpp"

namespace surfaced {
namespace {

/// Shares of the progress of the preparing section.
constexpr double kFuseUntil = 0.1;
constexpr double kOutliersUntil = 0.2;
constexpr double kSampleUntil = 0.5;
constexpr double kSmoothUntil = 0.8;

Json word_or_number(const char* word, double minimum, const char* title, const char* text, const char* unit) {
  return {{"oneOf",
           {Json{{"const", word}}, Json{{"type", "number"}, {minimum > 0 ? "minimum" : "exclusiveMinimum", minimum}}}},
          {"default", word},
          {"title", title},
          {"description", text},
          {"x-unit", unit}};
}

/// Takes the place of the cloud and notes what it did.
Status step(Prepared& prepared, const char* name, Result<PointCloud> cloud) {
  if (!cloud) return std::move(cloud).error();
  prepared.stages.push_back({{"name", name}, {"points_in", prepared.cloud.size()}, {"points_out", cloud->size()}});
  if (cloud->size() == 0) {
    return Error{ErrorCode::method_failed, std::string("the stage ") + name + " left none of " +
                                               std::to_string(prepared.cloud.size()) + " points"};
  }
  prepared.cloud = std::move(*cloud);
  return Done{};
}

Result<PointCloud> sample_of(const PointCloud& cloud, const Json& parameters, Context& context) {
  const Json& way = parameters.at("sample");
  const double share = parameters.at("sample_share");
  if (way == "hierarchy") return clustered(cloud, share, context);
  if (way == "wlop") return consolidated(cloud, share, context);
  const Json& cell = parameters.at("sample_cell");
  return sampled(cloud, cell.is_number() ? std::optional(cell.get<double>()) : std::nullopt, context);
}

/// Merges what repeats; without a distance that is given, only where points do.
Result<PointCloud> fuse(const PointCloud& cloud, const Json& distance, Context& context) {
  if (distance.is_number()) return fused(cloud, distance.get<double>(), context);
  const std::optional<NearRepeats> repeats = near_repeats_of(cloud.positions);
  if (!repeats) return cloud;
  return fused(cloud, repeats->tolerance, context);
}

Json smoothing_properties() {
  return Json{{"smooth",
               {{"enum", {"none", "jet", "bilateral"}},
                {"default", "none"},
                {"title", "Smoothing"},
                {"description",
                 "Moves the points towards the surface through their neighbours: jet onto quadrics, bilateral so that "
                 "edges stay. A method then goes through the moved points."}}},
              {"smooth_neighbours",
               {{"type", "integer"},
                {"minimum", 6},
                {"maximum", 1000},
                {"default", 24},
                {"title", "Neighbours for smoothing"},
                {"description", "More smooth more: as many as lie within some times the noise."},
                {"x-unit", "points"}}},
              {"normals",
               {{"enum", {"keep", "plane", "jet"}},
                {"default", "keep"},
                {"title", "Normals"},
                {"description",
                 "plane and jet estimate normals from 18 neighbours and turn them outwards, replacing those of the "
                 "cloud; keep leaves the cloud as it is."}}}};
}

Json sampling_properties() {
  return Json{
      {"sample",
       {{"enum", {"none", "grid", "hierarchy", "wlop"}},
        {"default", "none"},
        {"title", "Down-sampling"},
        {"description",
         "grid keeps one point a cell, the nearest to its centre; hierarchy one point a cluster; wlop draws points and "
         "spreads them evenly over the surface, which moves them."}}},
      {"sample_cell",
       word_or_number("auto", 0, "Size of a cell", "Side of the cells of sample=grid; auto is 2 spacings.", "input")},
      {"sample_share",
       {{"type", "number"},
        {"minimum", 0.001},
        {"maximum", 1},
        {"default", 0.25},
        {"title", "Share of the points to keep"},
        {"description", "For sample=hierarchy, which keeps at least as many, and sample=wlop."},
        {"x-unit", "1"}}}};
}

}  // namespace

Json preparing_properties() {
  Json properties{
      {"fuse",
       {{"oneOf", {Json{{"enum", {"none", "auto"}}}, Json{{"type", "number"}, {"exclusiveMinimum", 0}}}},
        {"default", "none"},
        {"title", "Points to merge"},
        {"description",
         "Merges points within this distance into their mean, before all other stages; auto tells the distance where "
         "points repeat within a tolerance, as in several scans of one thing, and merges none where they do not."},
        {"x-unit", "input"}}},
      {"outliers", word_or_number("none", 1, "Outliers to remove",
                                  "Removes points whose mean distance to their 12 nearest exceeds this many "
                                  "times the median of it; 2 to 4 is usual.",
                                  "1")}};
  properties.update(sampling_properties());
  properties.update(smoothing_properties());
  properties["drop_parts"] = {
      {"type", "number"},
      {"minimum", 0},
      {"maximum", 1},
      {"default", 0},
      {"title", "Parts of the mesh to drop"},
      {"description", "Drops parts that have fewer than this fraction of the triangles of the largest part."},
      {"x-unit", "1"}};
  return properties;
}

bool asks_for_preparing(const Json& parameters) {
  return parameters.at("fuse") != "none" || parameters.at("outliers") != "none" || parameters.at("sample") != "none" ||
         parameters.at("smooth") != "none" || parameters.at("normals") != "keep";
}

bool moves_points(const Json& parameters) {
  return parameters.at("fuse") != "none" || parameters.at("sample") == "wlop" || parameters.at("smooth") != "none";
}

Result<Prepared> prepare(PointCloud cloud, const Json& parameters, Context& context) {
  constexpr std::size_t kNeighboursOfNormals = 18;
  Prepared prepared{.cloud = std::move(cloud)};
  Status status = Done{};
  if (const Json& distance = parameters.at("fuse"); distance != "none") {
    context.enter("fuse", kFuseUntil);
    status = step(prepared, "fuse", fuse(prepared.cloud, distance, context));
  }
  if (const Json& factor = parameters.at("outliers"); status && factor.is_number()) {
    context.enter("outliers", kOutliersUntil);
    status = step(prepared, "outliers", without_outliers(prepared.cloud, factor.get<double>(), context));
  }
  if (status && parameters.at("sample") != "none") {
    context.enter("sample", kSampleUntil);
    status = step(prepared, "sample", sample_of(prepared.cloud, parameters, context));
  }
  if (const Json& way = parameters.at("smooth"); status && way != "none") {
    context.enter("smooth", kSmoothUntil);
    const Smoothing smoothing = way == "jet" ? Smoothing::jet : Smoothing::bilateral;
    status = step(prepared, "smooth",
                  smoothed(prepared.cloud, smoothing, parameters.at("smooth_neighbours").get<std::size_t>(), context));
  }
  if (const Json& way = parameters.at("normals"); status && way != "keep") {
    context.enter("normals", 1);
    const NormalFit fit = way == "jet" ? NormalFit::jet : NormalFit::plane;
    status = step(prepared, "normals", with_normals(prepared.cloud, fit, kNeighboursOfNormals, context));
  }
  if (!status) return std::move(status).error();
  return prepared;
}

void drop_small_parts(Reconstruction& result, double fraction) {
  const Components parts = components_of(result.mesh);
  std::vector<std::size_t> sizes(parts.count, 0);
  for (const std::uint32_t part : parts.of_triangle) ++sizes[part];
  const double limit = fraction * static_cast<double>(sizes.empty() ? 0 : *std::ranges::max_element(sizes));
  const auto small = [&](std::size_t part) { return static_cast<double>(sizes[part]) < limit; };
  std::vector<Triangle> kept;
  for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t) {
    if (!small(parts.of_triangle[t])) kept.push_back(result.mesh.triangles[t]);
  }
  if (kept.size() == result.mesh.triangles.size()) return;
  std::size_t dropped = 0;
  for (std::size_t part = 0; part < parts.count; ++part) dropped += small(part) ? 1U : 0U;
  result.warnings.push_back(std::to_string(dropped) + " parts of " +
                            std::to_string(result.mesh.triangles.size() - kept.size()) + " triangles dropped");
  result.mesh.triangles = std::move(kept);
}

}  // namespace surfaced
