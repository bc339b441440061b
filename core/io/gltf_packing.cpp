// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/gltf_packing.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "io/meshopt.hpp"
#include "io/scalars.hpp"

namespace surfaced::io {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";
/// A float32 has no more.
constexpr int kFloatBits = 24;

void require_extension(Json& json, std::string_view name) {
  json["extensionsUsed"] = Json::array({name});
  json["extensionsRequired"] = Json::array({name});
}

void pad(Bytes& bytes) {
  while (bytes.size() % 4 != 0) bytes.push_back(std::byte{0});
}

std::vector<float> floats_of(std::span<const std::byte> bytes) {
  std::vector<float> values;
  values.reserve(bytes.size() / sizeof(float));
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(float)) values.push_back(load_little<float>(&bytes[at]));
  return values;
}

/// The bounds that the accessor of positions promises, of what a reader gets.
template <class Points>
void set_bounds(Json& accessor, const Points& points) {
  std::array<float, 3> low{};
  low.fill(std::numeric_limits<float>::max());
  std::array<float, 3> high{};
  high.fill(std::numeric_limits<float>::lowest());
  for (const auto& p : points) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low.at(axis) = std::min(low.at(axis), static_cast<float>(p[axis]));
      high.at(axis) = std::max(high.at(axis), static_cast<float>(p[axis]));
    }
  }
  accessor["min"] = low;
  accessor["max"] = high;
}

/// Positions with fewer bits, and what a reader makes of them.
Bytes quantised(std::span<const std::byte> positions, int bits, Json& accessor) {
  Bytes packed = pack_vertices(with_fewer_bits(floats_of(positions), 3, bits), 3 * sizeof(float));
  Bytes back(positions.size());
  const MeshoptView view{.filter = MeshoptFilter::exponential,
                         .count = positions.size() / (3 * sizeof(float)),
                         .stride = 3 * sizeof(float)};
  if (unpack(view, packed, back)) {
    const std::vector<float> values = floats_of(back);
    std::vector<std::array<float, 3>> points;
    for (std::size_t i = 0; i < values.size(); i += 3) points.push_back({values[i], values[i + 1], values[i + 2]});
    set_bounds(accessor, points);
  }
  return packed;
}

}  // namespace

void pack_with_meshopt(GltfParts& parts, const std::vector<Triangle>& triangles, const std::optional<int>& bits) {
  Bytes packed_buffer;
  for (std::size_t i = 0; i < parts.arrays.size(); ++i) {
    const GltfArray& array = parts.arrays[i];
    const std::span<const std::byte> raw = std::span(parts.buffer).subspan(array.offset, array.count * array.stride);
    const bool indices = i + 1 == parts.arrays.size();
    const bool fewer_bits = i == 0 && bits && *bits < kFloatBits;
    const Bytes packed = indices      ? pack_triangles(triangles)
                         : fewer_bits ? quantised(raw, *bits, parts.json["accessors"][i])
                                      : pack_vertices(raw, array.stride);
    Json extension{{"buffer", 0},
                   {"byteOffset", packed_buffer.size()},
                   {"byteLength", packed.size()},
                   {"byteStride", array.stride},
                   {"mode", indices ? "TRIANGLES" : "ATTRIBUTES"},
                   {"count", array.count}};
    if (fewer_bits) extension["filter"] = "EXPONENTIAL";
    Json& view = parts.json["bufferViews"][i];
    view["buffer"] = 1;
    view["extensions"][std::string(kMeshoptExtension)] = std::move(extension);
    packed_buffer.insert(packed_buffer.end(), packed.begin(), packed.end());
    pad(packed_buffer);
  }
  // The second buffer has no bytes: it is what the views would refer to if they were unpacked.
  parts.json["buffers"] = Json::array(
      {Json{{"byteLength", packed_buffer.size()}},
       Json{{"byteLength", parts.buffer.size()}, {"extensions", {{kMeshoptExtension, {{"fallback", true}}}}}}});
  require_extension(parts.json, kMeshoptExtension);
  parts.buffer = std::move(packed_buffer);
}

Status pack_with_draco(GltfParts& parts, const TriangleMesh& mesh, const EncodeOptions& options) {
  Result<Bytes> packed = write_draco(mesh, options.quantization_bits, options.scalars);
  if (!packed) return std::move(packed).error();
  if (options.quantization_bits) {
    std::vector<std::string> unheard;
    const Result<TriangleMesh> back = read_draco_mesh(*packed, "the packed mesh", {}, unheard);
    if (!back) return back.error();
    set_bounds(parts.json["accessors"][0], back->positions);
  }
  const std::size_t length = packed->size();
  parts.buffer = std::move(*packed);
  pad(parts.buffer);
  Json& primitive = parts.json["meshes"][0]["primitives"][0];
  Json ids = Json::object();
  // Accessors were made in Draco's order of attributes.
  for (const auto& [name, accessor] : primitive["attributes"].items()) ids[name] = accessor;
  primitive["extensions"][kDracoExtension] = Json{{"bufferView", 0}, {"attributes", std::move(ids)}};
  for (Json& accessor : parts.json["accessors"]) {
    accessor.erase("bufferView");
    accessor.erase("byteOffset");
  }
  parts.json["bufferViews"] = Json::array({Json{{"buffer", 0}, {"byteLength", length}}});
  parts.json["buffers"] = Json::array({Json{{"byteLength", parts.buffer.size()}}});
  require_extension(parts.json, kDracoExtension);
  return Done{};
}

}  // namespace surfaced::io
