// SPDX-License-Identifier: GPL-3.0-or-later
// Scalars as they lie in binary files.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace surfaced::io {

/// The value at `from`, which need not be aligned; with Swapped its bytes are in the other order than the machine's.
template <class T, bool Swapped>
T load(const std::byte* from) {
  std::array<std::byte, sizeof(T)> bytes;
  std::memcpy(bytes.data(), from, sizeof(T));
  if constexpr (Swapped) std::ranges::reverse(bytes);
  return std::bit_cast<T>(bytes);
}

/// The little-endian value at `from`.
template <class T>
T load_little(const std::byte* from) {
  return load<T, std::endian::native != std::endian::little>(from);
}

/// Appends a value in little-endian order.
template <class T>
void append_little(std::vector<std::byte>& to, T value) {
  auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
  if constexpr (std::endian::native != std::endian::little) std::ranges::reverse(bytes);
  to.insert(to.end(), bytes.begin(), bytes.end());
}

}  // namespace surfaced::io
