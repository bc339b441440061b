// SPDX-License-Identifier: GPL-3.0-or-later
// LZF, the compression inside binary_compressed PCD (Marc Lehmann, liblzf 3.6: the format is two kinds of run).
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace surfaced::io {

/// Decompresses into `out`.
/// @return  the number of bytes written, or none if the data are broken or do not fit.
/// @cost    O(out).
inline std::optional<std::size_t> lzf_decompress(std::span<const std::byte> in, std::span<std::byte> out) {
  std::size_t from = 0;
  std::size_t to = 0;
  while (from < in.size()) {
    const auto control = std::to_integer<std::size_t>(in[from++]);
    if (control < 32) {
      const std::size_t length = control + 1;
      if (length > in.size() - from || length > out.size() - to) return std::nullopt;
      for (std::size_t i = 0; i < length; ++i) out[to++] = in[from++];
      continue;
    }
    std::size_t length = (control >> 5) + 2;
    if (length == 9) {
      if (from == in.size()) return std::nullopt;
      length += std::to_integer<std::size_t>(in[from++]);
    }
    if (from == in.size()) return std::nullopt;
    const std::size_t back = ((control & 31U) << 8 | std::to_integer<std::size_t>(in[from++])) + 1;
    if (back > to || length > out.size() - to) return std::nullopt;
    for (std::size_t i = 0; i < length; ++i, ++to) out[to] = out[to - back];
  }
  return to;
}

}  // namespace surfaced::io
