// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds in tests, read from text.
#pragma once

#include <span>
#include <string_view>

#include "io/io.hpp"
#include "support/codes.hpp"

namespace surfaced::testing {

inline std::span<const std::byte> as_bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

inline Result<RawCloud> parse_text(std::string_view text, const ReadLimits& limits = {}) {
  return parse_cloud(as_bytes(text), "test.ply", limits);
}

}  // namespace surfaced::testing
