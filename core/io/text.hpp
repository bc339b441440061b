// SPDX-License-Identifier: GPL-3.0-or-later
// Text of an input as it may stand in a message.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace surfaced::io {

/// The same bytes as characters.
inline std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// In quotes, cut to 60 characters, with '?' for what is not printable ASCII.
inline std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLength = 60;
  std::string result = "'";
  for (const char c : text.substr(0, kLength)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > kLength ? "...'" : "'");
}

}  // namespace surfaced::io
