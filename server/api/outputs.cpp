// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/outputs.hpp"

#include <algorithm>
#include <array>

#include "base/text.hpp"
#include "http/accept.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

constexpr auto kMeshes = std::to_array<OutputKind>(
    {{"mesh.glb", "model/gltf-binary", ""},
     {"mesh.gltf", "model/gltf+json", ""},
     {"mesh.drc", "application/octet-stream", "model/vnd.draco application/vnd.draco application/x-draco model/draco"},
     {"mesh.ply", "application/octet-stream", "model/ply model/x-ply application/ply application/x-ply text/ply"},
     {"mesh.obj", "model/obj", ""},
     {"mesh.stl", "model/stl", "application/sla"},
     {"mesh.3mf", "model/3mf", "application/vnd.ms-package.3dmanufacturing-3dmodel+xml"}});
constexpr auto kOthers =
    std::to_array<OutputKind>({{"report.json", "application/json", ""}, {"log.txt", "text/plain; charset=utf-8", ""}});
/// The points of a method that makes some.
constexpr OutputKind kPoints{"cloud.ply", "application/octet-stream", ""};

std::string names_of(const auto& kinds) { return joined(kinds, ", ", &OutputKind::name); }

bool is_kind_among(const auto& kinds, std::string_view name) {
  return std::ranges::find(kinds, name, &OutputKind::name) != kinds.end();
}

int quality_of_kind(const std::vector<http::MediaRange>& ranges, const OutputKind& kind) {
  int quality = http::quality_of(ranges, kind.media_type);
  for (std::string_view left = kind.aliases; !left.empty();) {
    const std::string_view alias = left.substr(0, left.find(' '));
    left.remove_prefix(std::min(left.size(), alias.size() + 1));
    // A wildcard speaks of the type that is served; an alias has to be named.
    const bool named = std::ranges::any_of(
        ranges, [&](const http::MediaRange& range) { return range.type + "/" + range.subtype == alias; });
    if (named) quality = std::max(quality, http::quality_of(ranges, alias));
  }
  return quality;
}

}  // namespace

std::span<const OutputKind> mesh_kinds() { return kMeshes; }

bool is_mesh(std::string_view output) { return is_kind_among(kMeshes, output); }

std::string_view media_type_of(std::string_view output) {
  const auto* mesh = std::ranges::find(kMeshes, output, &OutputKind::name);
  if (mesh != kMeshes.end()) return mesh->media_type;
  if (output == kPoints.name) return kPoints.media_type;
  const auto* other = std::ranges::find(kOthers, output, &OutputKind::name);
  return other != kOthers.end() ? other->media_type : std::string_view();
}

Result<std::vector<std::string>> outputs_for(std::span<const std::string> names, const MethodInfo& method) {
  std::vector<std::string> outputs;
  bool points = false;
  for (const std::string& name : names) {
    if (is_kind_among(kOthers, name)) continue;
    if (name == kPoints.name) {
      if (Status made = check_makes_cloud(method); !made.ok()) return std::move(made).error();
      points = true;
      continue;
    }
    if (!is_mesh(name)) {
      return http::wrong_value(
          ErrorCode::unknown_output, "outputs", name,
          "one of " + names_of(kMeshes) + ", " + std::string(kPoints.name) + ", " + names_of(kOthers));
    }
    if (std::ranges::find(outputs, name) == outputs.end()) outputs.push_back(name);
  }
  if (outputs.empty()) outputs.emplace_back(kMeshes.front().name);
  if (points) outputs.emplace_back(kPoints.name);
  for (const OutputKind& kind : kOthers) outputs.emplace_back(kind.name);
  return outputs;
}

Result<std::string> mesh_named(std::string_view format) {
  std::string name = "mesh." + std::string(format);
  if (is_mesh(name)) return name;
  return http::wrong_value(ErrorCode::unknown_output, "output", format, "one of glb, gltf, drc, ply, obj, stl, 3mf");
}

Result<std::string> negotiate_mesh(std::optional<std::string_view> accept, std::span<const std::string> made) {
  const auto ranges = http::parse_accept(accept.value_or("*/*"));
  const auto is_made = [&](std::string_view name) { return std::ranges::find(made, name) != made.end(); };
  const OutputKind* best = nullptr;
  int most = 0;
  for (const OutputKind& kind : kMeshes) {
    const int quality = quality_of_kind(ranges, kind);
    const bool better =
        quality > most || (quality == most && best != nullptr && !is_made(best->name) && is_made(kind.name));
    if (quality == 0 || !better) continue;
    best = &kind;
    most = quality;
  }
  if (best != nullptr) return std::string(best->name);
  return http::wrong_value(ErrorCode::not_acceptable, "Accept", accept.value_or(""),
                           "one of model/gltf-binary, model/gltf+json, model/obj, model/stl, model/3mf, model/ply, "
                           "application/x-draco, application/octet-stream");
}

}  // namespace surfaced::api
