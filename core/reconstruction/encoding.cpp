// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/encoding.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "quality/quality.hpp"
#include "reconstruction/position_set.hpp"

namespace surfaced {
namespace {

Point3 without_minus_zero(const Point3& p) { return {p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}; }

EncodingEffect compare(const std::vector<Point3>& computed, const std::vector<Point3>& stored) {
  EncodingEffect effect;
  PositionSet distinct(stored.size());
  for (std::size_t v = 0; v < stored.size(); ++v) {
    effect.max_error = std::max(effect.max_error, norm(stored[v] - computed[v]));
    if (!distinct.insert(without_minus_zero(stored[v]))) ++effect.merged_vertices;
  }
  return effect;
}

bool is_gltf(MeshFormat format) { return format == MeshFormat::glb || format == MeshFormat::gltf; }

/// The row of a table that a parameter names; the first one if it names none.
template <class T, std::size_t N>
T named(const std::array<std::pair<std::string_view, T>, N>& table, const Json& parameters, const char* parameter) {
  const std::string name = parameters.value(parameter, std::string(table.front().first));
  const auto found = std::ranges::find(table, std::string_view(name), [](const auto& row) { return row.first; });
  return found == table.end() ? table.front().second : found->second;
}

}  // namespace

Result<EncodingEffect> effect_of_encoding(const TriangleMesh& computed, const TriangleMesh& decoded,
                                          MeshFormat format) {
  if (format == MeshFormat::stl) return compare(computed.positions, positions_in_stl(computed));
  if (decoded.positions.size() != computed.positions.size()) {
    return Error{ErrorCode::internal_error, "the encoded mesh decodes to " + std::to_string(decoded.positions.size()) +
                                                " vertices instead of " + std::to_string(computed.positions.size())};
  }
  return compare(computed.positions, decoded.positions);
}

std::vector<std::string> unheeded_packing(MeshFormat format, const Json& parameters) {
  std::vector<std::string> warnings;
  const std::string name(name_of(format));
  const std::string compression = parameters.value("compression", "none");
  if (compression != "none" && !is_gltf(format)) {
    warnings.push_back("compression=" + compression + " changes nothing in " + name + ": glb and gltf take it");
  }
  const auto bits = parameters.find("quantization");
  if (bits == parameters.end() || !bits->is_number() || format == MeshFormat::drc) return warnings;
  if (is_gltf(format) && compression != "none") return warnings;
  warnings.push_back("quantization=" + bits->dump() + " changes nothing in " + name +
                     ": drc takes it, and with compression glb and gltf");
  return warnings;
}

Json encoding_json(const EncodingEffect& effect, MeshFormat format, const Json& parameters) {
  return Json{{"format", name_of(format)},
              {"compression", is_gltf(format) ? parameters.value("compression", "none") : std::string("none")},
              {"max_error", effect.max_error},
              {"merged_vertices", effect.merged_vertices}};
}

EncodeOptions encode_options_of(const Json& parameters, const TriangleMesh& mesh) {
  constexpr auto kUps = std::to_array<std::pair<std::string_view, UpAxis>>({{"y", UpAxis::y}, {"z", UpAxis::z}});
  constexpr auto kUnits = std::to_array<std::pair<std::string_view, Unit>>(
      {{"mm", Unit::millimetre}, {"cm", Unit::centimetre}, {"m", Unit::metre}, {"in", Unit::inch}});
  constexpr auto kCompressions = std::to_array<std::pair<std::string_view, MeshCompression>>(
      {{"none", MeshCompression::none}, {"draco", MeshCompression::draco}, {"meshopt", MeshCompression::meshopt}});
  EncodeOptions options;
  options.up = named(kUps, parameters, "up");
  options.unit = named(kUnits, parameters, "unit");
  options.compression = named(kCompressions, parameters, "compression");
  if (const auto bits = parameters.find("quantization"); bits != parameters.end() && bits->is_number()) {
    options.quantization_bits = bits->get<int>();
  }
  if (parameters.value("vertex_quality", false)) {
    VertexQuality quality = vertex_quality(mesh);
    options.scalars.push_back({"_L_OVER_R", std::move(quality.shortest_edge_to_circumradius)});
    options.scalars.push_back({"_R_OVER_L", std::move(quality.inradius_to_longest_edge)});
  }
  return options;
}

Result<std::vector<std::byte>> encode_again(const TriangleMesh& mesh, MeshFormat format, const Json& parameters,
                                            Json report) {
  EncodeOptions options = encode_options_of(parameters, mesh);
  Result<std::vector<std::byte>> bytes = encode_mesh(mesh, format, options);
  if (!bytes || !is_gltf(format) || !report.is_object()) return bytes;
  const Result<TriangleMesh> decoded = decode_mesh(*bytes, "the encoded mesh");
  if (!decoded) return decoded.error();
  Result<EncodingEffect> effect = effect_of_encoding(mesh, *decoded, format);
  if (!effect) return std::move(effect).error();
  if (const auto first = report.find("encoding"); first != report.end() && first->is_object()) {
    effect->max_error += first->value("max_error", 0.0);
  }
  report["encoding"] = encoding_json(*effect, format, parameters);
  for (const char* const of_the_run : {"stages", "resources"}) report.erase(of_the_run);
  if (report.contains("provenance")) report["provenance"].erase("input_sha256");
  options.extras_json = report.dump(-1, ' ', false, Json::error_handler_t::replace);
  return encode_mesh(mesh, format, options);
}

Status write_again(const TriangleMesh& mesh, const std::filesystem::path& file, const Json& parameters, Json report) {
  const Result<MeshFormat> format = mesh_format_of(file);
  if (!format) return format.error();
  const Result<std::vector<std::byte>> bytes = encode_again(mesh, *format, parameters, std::move(report));
  return bytes ? write_file(file, *bytes) : bytes.error();
}

}  // namespace surfaced
