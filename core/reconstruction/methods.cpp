// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/methods.hpp"

#include <algorithm>
#include <array>

#include "reconstruction/finishing_stage.hpp"
#include "reconstruction/method_table.hpp"
#include "reconstruction/orienting_stage.hpp"
#include "reconstruction/preparing_stage.hpp"
#include "reconstruction/reading_stage.hpp"

namespace surfaced {
namespace {

/// Parameters that concern the output and not the method.
Json common_properties() {
  return Json{
      {"up",
       {{"enum", {"y", "z"}},
        {"default", "y"},
        {"title", "Up axis of the cloud"},
        {"description", "glTF is Y-up: with z the node of a GLB is rotated, the vertices stay as they are."}}},
      {"quantization",
       {{"oneOf", {Json{{"const", "none"}}, Json{{"type", "integer"}, {"minimum", 8}, {"maximum", 30}}}},
        {"default", "none"},
        {"title", "Bits per coordinate in a Draco file or a packed GLB"},
        {"description",
         "none keeps float32 exactly; fewer bits make a smaller file and move the vertices, "
         "by what the report's encoding.max_error says. A GLB takes it with compression only."},
        {"x-unit", "bits"}}},
      {"unit",
       {{"enum", {"mm", "cm", "m", "in"}},
        {"default", "mm"},
        {"title", "Unit of the coordinates"},
        {"description", "What a coordinate of 1 means: stands in a 3MF and in the report; nothing is scaled."}}}};
}

const std::vector<Method>& table() {
  static const std::vector<Method> methods = all_methods();
  return methods;
}

const std::vector<MethodInfo>& infos() {
  static const std::vector<MethodInfo> all = [] {
    std::vector<MethodInfo> list;
    for (const Method& method : table()) list.push_back(method.info);
    return list;
  }();
  return all;
}

/// True of every method: stages that all share act before and after it.
constexpr std::string_view kStagesAct =
    "Guarantees are the method's, on the points it gets: fuse, outliers, sample, smooth and normals act before it; "
    "drop_parts, simplify and color_map change its mesh; normals of the cloud, its sensor's place and orient decide "
    "which "
    "side is the front, inwards as well.";

}  // namespace

Json schema_of(Json properties) {
  const Json common = common_properties();  // items() of a temporary would outlive it
  for (const auto& [name, schema] : common.items()) properties[name] = schema;
  const Json reading = reading_properties();
  for (const auto& [name, schema] : reading.items()) properties[name] = schema;
  const Json preparing = preparing_properties();
  for (const auto& [name, schema] : preparing.items()) properties[name] = schema;
  const Json orienting = orienting_properties();
  for (const auto& [name, schema] : orienting.items()) properties[name] = schema;
  const Json finishing = finishing_properties();
  for (const auto& [name, schema] : finishing.items()) properties[name] = schema;
  return Json{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
              {"type", "object"},
              {"additionalProperties", false},
              {"properties", std::move(properties)}};
}

std::span<const MethodInfo> methods() { return infos(); }

Result<const MethodInfo*> find_method(std::string_view id) {
  const auto found = std::ranges::find(infos(), id, &MethodInfo::id);
  if (found != infos().end()) return &*found;
  std::string known;
  for (const MethodInfo& info : infos()) known += (known.empty() ? "" : ", ") + info.id;
  return with_fault({ErrorCode::unknown_method, "method '" + std::string(id) + "' is unknown; there are: " + known},
                    {"method", std::string(id), "one of " + known});
}

Status check_makes_cloud(const MethodInfo& method) {
  if (method.makes_cloud) return Done{};
  std::string others;
  for (const MethodInfo& info : infos()) {
    if (info.makes_cloud) others += (others.empty() ? "" : ", ") + info.id;
  }
  return Error{ErrorCode::unknown_output,
               "method '" + method.id + "' makes a mesh but no cloud; those that do: " + others};
}

Json method_json(const MethodInfo& method) {
  Json limitations = method.limitations;
  limitations.push_back(kStagesAct);
  return Json{{"id", method.id},
              {"title", method.title},
              {"summary", method.summary},
              {"source", method.source},
              {"guarantees", method.guarantees},
              {"limitations", std::move(limitations)},
              {"outputs", method.makes_cloud ? Json{"mesh", "cloud"} : Json{"mesh"}},
              {"parameters", method.parameters}};
}

Json methods_json() {
  Json list = Json::array();
  for (const MethodInfo& method : methods()) list.push_back(method_json(method));
  return list;
}

const Method& method_of(const MethodInfo& info) {
  return *std::ranges::find(table(), info.id, [](const Method& m) { return m.info.id; });
}

}  // namespace surfaced
