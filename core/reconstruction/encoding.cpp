// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/encoding.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "quality/quality.hpp"
#include "reconstruction/position_set.hpp"
#include "reconstruction/report.hpp"

namespace surfaced {
namespace {

Point3 without_minus_zero(const Point3& p) { return {p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}; }

bool is_gltf(MeshFormat format) { return format == MeshFormat::glb || format == MeshFormat::gltf; }

bool heeds_bits(MeshFormat format, MeshCompression compression) {
  return format == MeshFormat::drc || (is_gltf(format) && compression != MeshCompression::none);
}

EncodingEffect compare(const std::vector<Point3>& computed, const std::vector<Point3>& stored) {
  EncodingEffect effect;
  PositionSet distinct(stored.size());
  for (std::size_t v = 0; v < stored.size(); ++v) {
    effect.max_error = std::max(effect.max_error, norm(stored[v] - computed[v]));
    if (!distinct.insert(without_minus_zero(stored[v]))) ++effect.merged_vertices;
  }
  return effect;
}

/// Makes vertices at one position one, and drops triangles of which two corners are.
void join_by_position(TriangleMesh& mesh) {
  std::vector<VertexIndex> order;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) order.emplace_back(v);
  const auto place = [&](VertexIndex v) { return without_minus_zero(mesh.positions[v]); };
  std::ranges::sort(
      order, [&](VertexIndex a, VertexIndex b) { return std::pair(place(a), a.value) < std::pair(place(b), b.value); });
  std::vector<VertexIndex> first(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool repeats = i > 0 && place(order[i]) == place(order[i - 1]);
    first[order[i]] = repeats ? first[order[i - 1]] : order[i];
  }
  for (Triangle& t : mesh.triangles) {
    for (VertexIndex& v : t) v = first[v];
  }
  std::erase_if(mesh.triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
}

bool same_surface(const Topology& a, const Topology& b) {
  return a.closed == b.closed && a.edge_manifold == b.edge_manifold && a.vertex_manifold == b.vertex_manifold &&
         a.components == b.components && a.genus == b.genus && a.boundary_edges == b.boundary_edges &&
         a.non_manifold_edges == b.non_manifold_edges && a.non_manifold_vertices == b.non_manifold_vertices;
}

/// One mesh and one format, with as many bits as one likes.
class Judging {
 public:
  Judging(const TriangleMesh& computed, MeshFormat format, const EncodeOptions& options)
      : computed_(computed), format_(format), options_(options) {
    if (is_quantised()) crossings_ = count_self_intersections(computed_);
  }

  EncodingEffect operator()(const std::vector<Point3>& stored) const {
    EncodingEffect effect = compare(computed_.positions, stored);
    if (effect.merged_vertices == 0 && !is_quantised()) return effect;
    TriangleMesh joined{.positions = stored, .triangles = computed_.triangles, .normals = {}, .colors = {}};
    if (effect.merged_vertices > 0) {
      join_by_position(joined);
      const Topology topology = topology_of(joined);
      if (!same_surface(topology, topology_of(computed_))) effect.by_position = topology;
    }
    if (is_quantised()) {
      const std::size_t now = count_self_intersections(joined);
      effect.crossings_made = now > crossings_ ? now - crossings_ : 0;
    }
    return effect;
  }

  /// Tries more and more bits.
  Result<std::optional<int>> least_bits(Context& context) const {
    EncodeOptions options = options_;
    options.scalars.clear();
    options.extras_json.clear();
    for (int bits = *options_.quantization_bits + 1; bits <= kMostBits; ++bits) {
      if (context.cancelled()) return Error{ErrorCode::cancelled, "cancelled while bits per coordinate were tried"};
      options.quantization_bits = bits;
      const Result<std::vector<std::byte>> bytes = encode_mesh(computed_, format_, options);
      if (!bytes) return bytes.error();
      const Result<TriangleMesh> decoded = decode_mesh(*bytes, "the encoded mesh");
      if (!decoded) return decoded.error();
      const EncodingEffect effect = (*this)(decoded->positions);
      if (!effect.by_position && effect.crossings_made == 0U) return std::optional(bits);
    }
    return std::optional<int>();
  }

 private:
  bool is_quantised() const { return heeds_bits(format_, options_.compression) && options_.quantization_bits; }

  static constexpr int kMostBits = 30;
  const TriangleMesh& computed_;
  MeshFormat format_;
  const EncodeOptions& options_;
  std::size_t crossings_ = 0;
};

/// The row of a table that a parameter names; the first one if it names none.
template <class T, std::size_t N>
T named(const std::array<std::pair<std::string_view, T>, N>& table, const Json& parameters, const char* parameter) {
  const std::string name = parameters.value(parameter, std::string(table.front().first));
  const auto found = std::ranges::find(table, std::string_view(name), [](const auto& row) { return row.first; });
  return found == table.end() ? table.front().second : found->second;
}

}  // namespace

Result<EncodingEffect> effect_of_encoding(const TriangleMesh& computed, const TriangleMesh& decoded, MeshFormat format,
                                          const EncodeOptions& options, Context& context) {
  const Judging judge(computed, format, options);
  if (format == MeshFormat::stl) return judge(positions_in_stl(computed));
  if (decoded.positions.size() != computed.positions.size()) {
    return Error{ErrorCode::internal_error, "the encoded mesh decodes to " + std::to_string(decoded.positions.size()) +
                                                " vertices instead of " + std::to_string(computed.positions.size())};
  }
  EncodingEffect effect = judge(decoded.positions);
  if (!effect.crossings_made || (!effect.by_position && *effect.crossings_made == 0)) return effect;
  const Result<std::optional<int>> bits = judge.least_bits(context);
  if (!bits) return bits.error();
  effect.least_bits = *bits;
  return effect;
}

std::vector<std::string> encoding_warnings(const EncodingEffect& effect) {
  std::vector<std::string> warnings;
  if (effect.merged_vertices > 0) {
    warnings.push_back(std::to_string(effect.merged_vertices) +
                       " vertices share a position with another after encoding");
  }
  const std::string remedy =
      effect.least_bits ? "; quantization=" + std::to_string(*effect.least_bits) + " changes nothing" : std::string();
  if (const auto& t = effect.by_position) {
    warnings.push_back("for readers that join vertices by position the file has " +
                       std::to_string(t->non_manifold_edges) + " edges of more than two triangles, " +
                       std::to_string(t->non_manifold_vertices) + " vertices where surfaces touch, " +
                       std::to_string(t->boundary_edges) + " open edges and " + std::to_string(t->components) +
                       " components, other than by index" + remedy);
  }
  if (effect.crossings_made.value_or(0) > 0) {
    warnings.push_back("the bits per coordinate make " + std::to_string(*effect.crossings_made) +
                       " pairs of triangles cross" + remedy);
  }
  return warnings;
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
  Json json{{"format", name_of(format)},
            {"compression", is_gltf(format) ? parameters.value("compression", "none") : std::string("none")},
            {"max_error", effect.max_error},
            {"merged_vertices", effect.merged_vertices},
            {"by_position", nullptr},
            {"crossings_made", nullptr},
            {"least_bits", nullptr}};
  if (effect.by_position) json["by_position"] = topology_json(*effect.by_position);
  if (effect.crossings_made) json["crossings_made"] = *effect.crossings_made;
  if (effect.least_bits) json["least_bits"] = *effect.least_bits;
  return json;
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
  Context context;
  Result<EncodingEffect> effect = effect_of_encoding(mesh, *decoded, format, options, context);
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
