// SPDX-License-Identifier: GPL-3.0-or-later
// EXT_meshopt_compression: what lies behind a bufferView, packed by meshoptimizer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "io/formats.hpp"

namespace surfaced::io {

inline constexpr std::string_view kMeshoptExtension = "EXT_meshopt_compression";

enum class MeshoptMode : std::uint8_t { attributes, triangles, indices };
enum class MeshoptFilter : std::uint8_t { none, octahedral, quaternion, exponential };

/// Elements of a packed bufferView.
struct MeshoptView {
  MeshoptMode mode = MeshoptMode::attributes;
  MeshoptFilter filter = MeshoptFilter::none;
  std::size_t count = 0;
  std::size_t stride = 0;
};

/// Whether mode, filter, count and stride go together, as the extension demands.
bool is_sound(const MeshoptView& view);

/// Unpacks count * stride bytes; false if the bytes are damaged. What they mean is not judged.
/// @pre  is_sound(view), target has the size.
bool unpack(const MeshoptView& view, std::span<const std::byte> packed, std::span<std::byte> target);

/// `stride` a multiple of 4 up to 256.
Bytes pack_vertices(std::span<const std::byte> vertices, std::size_t stride);
/// Triangles keep their order; each may begin at another of its corners.
Bytes pack_triangles(const std::vector<Triangle>& triangles);

/// Floats, `components` a vertex, with a common exponent a vertex and this many bits (1 to 24) a component: what
/// `exponential` undoes.
Bytes with_fewer_bits(std::span<const float> values, std::size_t components, int bits);

}  // namespace surfaced::io
