// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <string_view>

namespace surfaced {

/// The texts one behind the other, with a separator between them: "a, b, c".
/// @param text_of  what stands for an entry
template <class Entries, class TextOf = std::identity>
std::string joined(Entries&& entries, std::string_view separator = ", ", TextOf text_of = {}) {
  std::string text;
  bool first = true;
  for (auto&& each : entries) {
    if (!first) text += separator;
    first = false;
    text += std::invoke(text_of, each);
  }
  return text;
}

/// A share in percent: "12.5 %" with one decimal, "13 %" with none.
inline std::string percent(double share, int decimals = 0) {
  const long long scale = decimals == 0 ? 1 : 10;
  const long long value = std::llround(100.0 * static_cast<double>(scale) * share);
  const std::string whole = std::to_string(value / scale);
  return decimals == 0 ? whole + " %" : whole + "." + std::to_string(value % scale) + " %";
}

/// Letters of ASCII alone, whatever the locale.
constexpr char in_lower_case(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

inline std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = in_lower_case(c);
  return lower;
}

}  // namespace surfaced
