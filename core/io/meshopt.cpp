// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Khronos, EXT_meshopt_compression; packed and unpacked by meshoptimizer (A. Kapoulkine), whose decoders take
// untrusted bytes as long as counts and strides are sound.
#include "io/meshopt.hpp"

#include <meshoptimizer.h>

#include <cstring>

namespace surfaced::io {
namespace {

/// The versions that the extension prescribes.
constexpr int kVertexVersion = 0;
constexpr int kIndexVersion = 1;

const unsigned char* raw(const std::byte* bytes) { return reinterpret_cast<const unsigned char*>(bytes); }
unsigned char* raw(std::byte* bytes) { return reinterpret_cast<unsigned char*>(bytes); }

}  // namespace

bool is_sound(const MeshoptView& view) {
  if (view.mode != MeshoptMode::attributes) {
    const bool whole = view.mode == MeshoptMode::indices || view.count % 3 == 0;
    return whole && (view.stride == 2 || view.stride == 4) && view.filter == MeshoptFilter::none;
  }
  if (view.stride == 0 || view.stride % 4 != 0 || view.stride > 256) return false;
  if (view.filter == MeshoptFilter::octahedral) return view.stride == 4 || view.stride == 8;
  return view.filter != MeshoptFilter::quaternion || view.stride == 8;
}

bool unpack(const MeshoptView& view, std::span<const std::byte> packed, std::span<std::byte> target) {
  const unsigned char* from = raw(packed.data());
  if (view.mode == MeshoptMode::triangles) {
    return meshopt_decodeIndexBuffer(target.data(), view.count, view.stride, from, packed.size()) == 0;
  }
  if (view.mode == MeshoptMode::indices) {
    return meshopt_decodeIndexSequence(target.data(), view.count, view.stride, from, packed.size()) == 0;
  }
  if (meshopt_decodeVertexBuffer(target.data(), view.count, view.stride, from, packed.size()) != 0) return false;
  if (view.filter == MeshoptFilter::octahedral) meshopt_decodeFilterOct(target.data(), view.count, view.stride);
  if (view.filter == MeshoptFilter::quaternion) meshopt_decodeFilterQuat(target.data(), view.count, view.stride);
  if (view.filter == MeshoptFilter::exponential) meshopt_decodeFilterExp(target.data(), view.count, view.stride);
  return true;
}

Bytes pack_vertices(std::span<const std::byte> vertices, std::size_t stride) {
  meshopt_encodeVertexVersion(kVertexVersion);
  const std::size_t count = vertices.size() / stride;
  Bytes packed(meshopt_encodeVertexBufferBound(count, stride));
  packed.resize(meshopt_encodeVertexBuffer(raw(packed.data()), packed.size(), vertices.data(), count, stride));
  return packed;
}

Bytes pack_triangles(const std::vector<Triangle>& triangles) {
  meshopt_encodeIndexVersion(kIndexVersion);
  std::vector<unsigned> indices;
  indices.reserve(3 * triangles.size());
  std::size_t vertices = 0;
  for (const Triangle& t : triangles) {
    for (const VertexIndex v : t) {
      indices.push_back(v.value);
      vertices = std::max<std::size_t>(vertices, v + std::size_t{1});
    }
  }
  Bytes packed(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  packed.resize(meshopt_encodeIndexBuffer(raw(packed.data()), packed.size(), indices.data(), indices.size()));
  return packed;
}

Bytes with_fewer_bits(std::span<const float> values, std::size_t components, int bits) {
  Bytes result(values.size_bytes());
#if MESHOPTIMIZER_VERSION > 180  // since then to be named what was the only way: an exponent a vertex
  meshopt_encodeFilterExp(result.data(), values.size() / components, components * sizeof(float), bits, values.data(),
                          meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(result.data(), values.size() / components, components * sizeof(float), bits, values.data());
#endif
  return result;
}

}  // namespace surfaced::io
