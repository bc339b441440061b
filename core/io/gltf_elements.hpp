// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers in the accessors of a glTF, also quantised ones.
#pragma once

#include <algorithm>

#include "io/gltf_container.hpp"
#include "io/scalars.hpp"

namespace surfaced::io {

enum Component {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126
};

/// A component as it is stored.
inline double stored_at(const Elements& elements, std::size_t i, std::size_t c) {
  const std::byte* const at = elements.at(i);
  switch (elements.component_type) {
    case kByte:
      return load_little<std::int8_t>(at + c);
    case kUnsignedByte:
      return load_little<std::uint8_t>(at + c);
    case kShort:
      return load_little<std::int16_t>(at + 2 * c);
    case kUnsignedShort:
      return load_little<std::uint16_t>(at + 2 * c);
    default:
      return static_cast<double>(load_little<float>(at + 4 * c));
  }
}

/// What stands for 1 where integers are normalised.
inline double full_scale(int component_type) {
  switch (component_type) {
    case kByte:
      return 127;
    case kUnsignedByte:
      return 255;
    case kShort:
      return 32767;
    case kUnsignedShort:
      return 65535;
    default:
      return 1;
  }
}

/// Types of KHR_mesh_quantization beside float.
inline bool is_quantised(int component_type) { return component_type >= kByte && component_type <= kUnsignedShort; }

inline double component_at(const Elements& elements, std::size_t i, std::size_t c) {
  const double stored = stored_at(elements, i, c);
  // `normalized` says nothing of floats.
  const bool scaled = elements.normalized && is_quantised(elements.component_type);
  return scaled ? std::max(stored / full_scale(elements.component_type), -1.0) : stored;
}

}  // namespace surfaced::io
