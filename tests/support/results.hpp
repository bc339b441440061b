// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds in tests, read from text.
#pragma once

#include <gtest/gtest.h>

#include <span>
#include <string_view>
#include <utility>

#include "io/io.hpp"
#include "support/codes.hpp"

namespace surfaced::testing {

inline std::span<const std::byte> as_bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

inline Result<RawCloud> parse_text(std::string_view text, const ReadLimits& limits = {}) {
  return parse_cloud(as_bytes(text), "test.ply", limits);
}

/// The cloud; a failure of the test if it is refused.
inline RawCloud read(std::string_view text, const ReadOptions& options = {}) {
  auto cloud = parse_cloud(as_bytes(text), "test", options);
  EXPECT_EQ(code_of(cloud), "ok") << detail_of(cloud);
  return cloud ? std::move(*cloud) : RawCloud{};
}

}  // namespace surfaced::testing
