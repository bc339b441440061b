// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/ply_ascii.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "io/text.hpp"

namespace surfaced::io {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }

/// What Windows' C library prints: 1.#INF, 1.#QNAN, 1.#SNAN, 1.#IND, with zeros after it.
bool parse_windows_special(std::string_view text, double& value) {
  if (!text.starts_with("1.#")) return false;
  text.remove_prefix(3);
  const bool infinite = text.starts_with("INF");
  if (!infinite && !text.starts_with("QNAN") && !text.starts_with("SNAN") && !text.starts_with("IND")) return false;
  value = infinite ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  return true;
}

/// A number beyond the type's range: infinite, or 0 if it is too small.
double beyond_range(std::string_view text) {
  long double wide = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), wide);
  if (parsed.ec == std::errc{}) return static_cast<double>(wide);
  return text.find("e-") != std::string_view::npos || text.find("E-") != std::string_view::npos
             ? 0.0
             : std::numeric_limits<double>::infinity();
}

template <class T>
bool parse_floating(std::string_view text, double& value) {
  T parsed = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, parsed);
  if (result.ec == std::errc{} && result.ptr == end) {
    value = static_cast<double>(parsed);
    return true;
  }
  const bool negative = text.starts_with('-');
  if (result.ec == std::errc::result_out_of_range && result.ptr == end) {
    value = static_cast<double>(static_cast<T>(std::abs(beyond_range(text))));
  } else if (!parse_windows_special(text.substr(negative ? 1 : 0), value)) {
    return false;
  }
  if (negative) value = -value;
  return true;
}

std::pair<double, double> range_of(Scalar type) {
  const auto limits = []<class T>(T) {
    return std::pair<double, double>{std::numeric_limits<T>::min(), std::numeric_limits<T>::max()};
  };
  switch (type) {
    case Scalar::int8:
      return limits(std::int8_t{});
    case Scalar::uint8:
      return limits(std::uint8_t{});
    case Scalar::int16:
      return limits(std::int16_t{});
    case Scalar::uint16:
      return limits(std::uint16_t{});
    case Scalar::int32:
      return limits(std::int32_t{});
    default:
      return limits(std::uint32_t{});
  }
}

}  // namespace

std::string_view AsciiRows::after_blanks() {
  for (;;) {
    const std::string_view window = text_of(source_.peek(kTokenLimit));
    std::size_t blanks = 0;
    while (blanks < window.size() && is_blank(window[blanks])) ++blanks;
    source_.advance(blanks);
    if (blanks < window.size() || window.empty()) {
      const std::string_view rest = window.substr(blanks);
      return rest.size() >= kTokenLimit ? rest : text_of(source_.peek(kTokenLimit));
    }
  }
}

bool AsciiRows::begin_row() {
  for (;;) {
    const std::string_view rest = after_blanks();
    if (rest.empty()) return false;
    if (!is_line_end(rest.front())) return true;
    source_.advance(1);
  }
}

std::string_view AsciiRows::token() {
  const std::string_view rest = after_blanks();
  std::size_t length = 0;
  const std::size_t most = std::min(rest.size(), kTokenLimit);
  while (length < most && !is_blank(rest[length]) && !is_line_end(rest[length])) ++length;
  source_.advance(length);
  return rest.substr(0, length);
}

bool AsciiRows::at_line_end() {
  const std::string_view rest = after_blanks();
  return rest.empty() || is_line_end(rest.front());
}

bool parse_number(std::string_view text, Scalar type, double& value) {
  if (text.size() >= kTokenLimit) return false;
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  if (type == Scalar::float32) return parse_floating<float>(text, value);
  if (type == Scalar::float64) return parse_floating<double>(text, value);
  std::int64_t whole = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, whole);
  if (result.ec == std::errc{} && result.ptr == end) {
    value = static_cast<double>(whole);
  } else if (!parse_floating<double>(text, value) || value != std::trunc(value)) {
    return false;
  }
  const auto [low, high] = range_of(type);
  return value >= low && value <= high;
}

}  // namespace surfaced::io
