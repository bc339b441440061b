// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/hole_stage.hpp"

#include <algorithm>

namespace surfaced {
namespace {

/// Loops listed one by one in the report, and in its warnings.
constexpr std::size_t kMostListed = 100;
constexpr std::size_t kMostWarnings = 20;

Json report_json(const FillReport& report, const TriangleMesh& mesh) {
  Json left = Json::array();
  for (const LoopLeft& loop : report.left) {
    if (left.size() == kMostListed) break;
    left.push_back(Json{{"through", mesh.positions[loop.vertex]}, {"edges", loop.edges}, {"reason", loop.reason}});
  }
  return Json{{"loops", report.loops},
              {"filled", report.filled},
              {"spans_opened", report.spans_opened},
              {"triangles_cut", report.triangles_cut},
              {"filled_by_library", report.filled_by_library},
              {"vertices_added", report.vertices_added},
              {"triangles_added", report.triangles_added},
              {"loops_left", report.left.size()},
              {"left", std::move(left)}};
}

void warn(const FillReport& report, const TriangleMesh& mesh, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < std::min(report.left.size(), kMostWarnings); ++i) {
    const LoopLeft& loop = report.left[i];
    warnings.push_back("the loop of " + std::to_string(loop.edges) + " edges through vertex " +
                       Json(mesh.positions[loop.vertex]).dump() + " stays open: " + loop.reason);
  }
  if (report.left.size() > kMostWarnings) {
    warnings.push_back(std::to_string(report.left.size() - kMostWarnings) + " more loops stay open");
  }
}

}  // namespace

Json fill_holes_property(std::string_view default_value) {
  Json names = Json::array({default_value});
  for (const std::string_view name : {"small", "none", "all"}) {
    if (name != default_value) names.push_back(name);
  }
  return {{"enum", std::move(names)},
          {"default", default_value},
          {"title", "Holes to fill"},
          {"description",
           "small closes holes of up to 30 edges without new vertices; all fills every hole up to half the area of its "
           "component, with new vertices fitted to the surface around it; none leaves all open."}};
}

Json rotation_property() {
  return {{"enum", {"normal", "none", "paper"}},
          {"default", "normal"},
          {"title", "Where the new vertices of a filled hole go"},
          {"description",
           "normal turns the new triangles to normals that continue those around the hole; none spans the hole like a "
           "membrane; paper turns the points by a right angle first, as printed."}};
}

Rotation rotation_of(const Json& parameters) {
  const Json& name = parameters.at("rotation");
  return name == "none" ? Rotation::none : name == "paper" ? Rotation::paper : Rotation::normal;
}

Status run_hole_stage(Reconstruction& result, const FillParameters& parameters, Context& context) {
  context.enter("fill_holes", 1);
  const Result<FillReport> report = fill_holes(result.mesh, parameters, context);
  if (!report) return report.error();
  if (report->filled > 0) orient_outwards(result.mesh);
  warn(*report, result.mesh, result.warnings);
  result.hole_filling = report_json(*report, result.mesh);
  return Done{};
}

Status run_hole_parameter(Reconstruction& result, const Json& parameters, Context& context) {
  const Json& holes = parameters.at("fill_holes");
  if (holes == "none") return Done{};
  const auto which = holes == "all" ? FillParameters::Holes::all : FillParameters::Holes::small;
  return run_hole_stage(result, {.holes = which}, context);
}

}  // namespace surfaced
