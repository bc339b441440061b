#include "api/submission.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "reconstruction/reconstruction.hpp"

namespace surfaced::api {
namespace {

struct OutputKind {
  std::string_view name;
  std::string_view media_type;
};
constexpr auto kMeshes = std::to_array<OutputKind>({{"mesh.glb", "model/gltf-binary"},
                                                    {"mesh.gltf", "model/gltf+json"},
                                                    {"mesh.drc", "application/octet-stream"},
                                                    {"mesh.ply", "application/octet-stream"},
                                                    {"mesh.obj", "model/obj"},
                                                    {"mesh.stl", "model/stl"},
                                                    {"mesh.3mf", "model/3mf"}});
constexpr auto kOthers =
    std::to_array<OutputKind>({{"report.json", "application/json"}, {"log.txt", "text/plain; charset=utf-8"}});
constexpr OutputKind kPoints{"cloud.ply", "application/octet-stream"};

/// Names that are reserved and not handed to the method.
constexpr auto kReserved =
    std::to_array<std::string_view>({"method", "output", "outputs", "wait", "ttl_seconds", "labels", "webhook"});

constexpr double kShortestTtl = 60;
constexpr double kLongestTtl = 30 * 24 * 3600;

std::string names_of(const auto& kinds) {
  std::string names;
  for (const OutputKind& kind : kinds) names += (names.empty() ? "" : ", ") + std::string(kind.name);
  return names;
}

bool is_among(const auto& kinds, std::string_view name) {
  return std::ranges::find(kinds, name, &OutputKind::name) != kinds.end();
}

/// Reads "mesh.ply,report.json": one mesh; report and log are always made.
Result<std::string> mesh_among(std::string_view list) {
  const std::string_view whole = list;
  std::string mesh;
  while (!list.empty()) {
    const std::string name(list.substr(0, list.find(',')));
    list.remove_prefix(std::min(list.size(), name.size() + 1));
    if (is_among(kOthers, name) || name == kPoints.name) continue;
    if (!is_among(kMeshes, name)) {
      return Error{ErrorCode::unknown_output, "outputs names '" + name + "'; there are " + names_of(kMeshes) + ", " +
                                                  std::string(kPoints.name) + ", " + names_of(kOthers)};
    }
    if (!mesh.empty() && mesh != name) {
      return Error{ErrorCode::unknown_output,
                   "outputs names more than one mesh: '" + std::string(whole) + "'; a job makes one"};
    }
    mesh = name;
  }
  return mesh.empty() ? std::string(kMeshes.front().name) : mesh;
}

Result<std::string> wanted_mesh(const http::Query& query, Door door) {
  auto text = single(query, door == Door::reconstruct ? "output" : "outputs");
  if (!text || text->empty()) return text ? Result<std::string>(std::string(kMeshes.front().name)) : text;
  if (door == Door::jobs) return mesh_among(*text);
  const std::string name = "mesh." + *text;
  if (is_among(kMeshes, name)) return name;
  return Error{ErrorCode::unknown_output, "output is '" + *text + "'; allowed are glb, gltf, drc, ply, obj, stl, 3mf"};
}

/// Whether the list of outputs names the method's cloud; unknown_output if it does and the method makes none.
Result<bool> wants_points(const http::Query& query, Door door, const MethodInfo& method) {
  const auto list = door == Door::jobs ? single(query, "outputs") : Result<std::string>(std::string());
  if (!list) return list.error();
  for (std::string_view rest = *list; !rest.empty();) {
    const std::string_view name = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), name.size() + 1));
    if (name != kPoints.name) continue;
    if (Status made = check_makes_cloud(method); !made) return std::move(made).error();
    return true;
  }
  return false;
}

/// A reserved name that this path does not take is not ignored in silence.
Status refuse_reserved(const http::Query& query, Door door) {
  constexpr auto kForReconstruct = std::to_array<std::string_view>({"method", "output"});
  constexpr auto kForJobs = std::to_array<std::string_view>({"method", "outputs", "ttl_seconds"});
  for (const auto& [name, value] : query) {
    const bool reserved = std::ranges::find(kReserved, name) != kReserved.end();
    const bool taken = door == Door::jobs ? std::ranges::find(kForJobs, name) != kForJobs.end()
                                          : std::ranges::find(kForReconstruct, name) != kForReconstruct.end();
    if (reserved && !taken) {
      return Error{ErrorCode::unknown_parameter, "'" + name + "' is not taken by this path"};
    }
  }
  return Done{};
}

http::Query method_parameters(const http::Query& query) {
  http::Query parameters;
  std::ranges::copy_if(query, std::back_inserter(parameters),
                       [](const auto& pair) { return std::ranges::find(kReserved, pair.first) == kReserved.end(); });
  return parameters;
}

}  // namespace

std::string_view media_type_of(std::string_view output) {
  const auto* mesh = std::ranges::find(kMeshes, output, &OutputKind::name);
  if (mesh != kMeshes.end()) return mesh->media_type;
  if (output == kPoints.name) return kPoints.media_type;
  const auto* other = std::ranges::find(kOthers, output, &OutputKind::name);
  return other != kOthers.end() ? other->media_type : std::string_view();
}

Result<std::string> single(const http::Query& query, std::string_view name) {
  std::string value;
  std::size_t count = 0;
  for (const auto& [key, text] : query) {
    if (key == name && ++count == 1) value = text;
  }
  if (count > 1) {
    return Error{ErrorCode::invalid_parameter,
                 "'" + std::string(name) + "' is given " + std::to_string(count) + " times; once is allowed"};
  }
  return value;
}

Result<double> number_within(std::string_view name, std::string_view text, double least, double most) {
  double value = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (failed == std::errc() && end == text.data() + text.size() && value >= least && value <= most) return value;
  return Error{ErrorCode::invalid_parameter, "'" + std::string(name) + "' is '" + std::string(text) +
                                                 "'; allowed is a number from " + nlohmann::json(least).dump() +
                                                 " to " + nlohmann::json(most).dump()};
}

Result<Submission> read_submission(const http::Query& query, Door door, std::chrono::seconds default_ttl) {
  if (Status taken = refuse_reserved(query, door); !taken.ok()) return taken.error();
  const auto id = single(query, "method");
  if (!id) return id.error();
  const auto method = find_method(id->empty() ? methods().front().id : *id);
  if (!method) return method.error();
  auto parameters = parameters_from_text(**method, method_parameters(query));
  if (!parameters) return std::move(parameters).error();
  auto mesh = wanted_mesh(query, door);
  if (!mesh) return std::move(mesh).error();
  Submission submission{(*method)->id, std::move(*parameters), {std::move(*mesh)}, default_ttl};
  const auto points = wants_points(query, door, **method);
  if (!points) return points.error();
  if (*points) submission.outputs.emplace_back(kPoints.name);
  for (const OutputKind& kind : kOthers) submission.outputs.emplace_back(kind.name);
  const auto ttl = single(query, "ttl_seconds");
  if (!ttl) return ttl.error();
  if (!ttl->empty()) {
    const auto seconds = number_within("ttl_seconds", *ttl, kShortestTtl, kLongestTtl);
    if (!seconds) return seconds.error();
    submission.ttl = std::chrono::seconds(static_cast<std::int64_t>(*seconds));
  }
  return submission;
}

}  // namespace surfaced::api
