// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/text_lines.hpp"

#include <algorithm>
#include <cstring>

#include "io/text.hpp"

namespace surfaced::io {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

/// Offset of the first line end, or npos.
std::size_t line_end_in(std::string_view text) {
  const std::size_t feed = text.find('\n');
  return std::min(feed, text.substr(0, feed).find('\r'));
}

std::string_view without_quotes(std::string_view value) {
  const bool quoted = value.size() >= 2 && value.front() == '"' && value.back() == '"';
  return quoted ? trimmed(value.substr(1, value.size() - 2)) : value;
}

/// Where the value that begins the line ends: at a separator outside of quotes.
std::size_t value_end(std::string_view line, char separator) {
  bool inside = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') inside = !inside;
    if (!inside && (line[i] == separator || (separator == ' ' && is_blank(line[i])))) return i;
  }
  return line.size();
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

bool is_empty_row(std::string_view line, char separator) {
  if (separator == ' ' || std::ranges::count(line, separator) < 2) return false;
  return std::ranges::all_of(line, [&](char c) { return c == separator || c == '"' || is_blank(c); });
}

std::string_view take_word(std::string_view& text) {
  text = trimmed(text);
  const auto* const end = std::ranges::find_if(text, is_blank);
  const std::string_view word = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(word.size());
  return word;
}

Error TextLines::error(ErrorCode code, const std::string& what) const {
  return {code, std::string(name_) + ": line " + std::to_string(number_) + ": " + what};
}

Result<bool> TextLines::next() {
  const std::string_view window = text_of(source_.peek(kLongest + 2)).substr(0, kLongest + 2);
  if (source_.failure()) return *source_.failure();
  if (window.empty()) return false;
  ++number_;
  const std::size_t end = line_end_in(window);
  if (end == std::string_view::npos && window.size() > kLongest) {
    return malformed("longer than " + std::to_string(kLongest) + " bytes");
  }
  raw_ = window.substr(0, end);
  text_ = trimmed(raw_);
  // DOS ended texts so.
  if (text_ == "\x1a" && end == std::string_view::npos) return false;
  std::size_t length = std::min(end, window.size());
  if (end != std::string_view::npos) length += window.substr(end).starts_with("\r\n") ? 2U : 1U;
  source_.advance(length);
  return true;
}

void Columns::push_trimmed(std::string_view value) {
  if (count_ < kMost) values_[count_] = without_quotes(value);
  ++count_;
}

void Columns::split(std::string_view line, char separator, bool quoted) {
  count_ = 0;
  if (quoted && line.find('"') != std::string_view::npos) {
    for (line = trimmed(line); !line.empty();) {
      const std::size_t end = value_end(line, separator);
      push_trimmed(trimmed(line.substr(0, end)));
      line.remove_prefix(std::min(end + 1, line.size()));
      if (separator == ' ') line = trimmed(line);
    }
    return;
  }
  if (separator == ' ') {
    const char* at = line.data();
    const char* const end = at + line.size();
    for (;;) {
      while (at != end && is_blank(*at)) ++at;
      if (at == end) return;
      const char* const word = at;
      while (at != end && !is_blank(*at)) ++at;
      push_trimmed({word, static_cast<std::size_t>(at - word)});
    }
  }
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(separator), line.size());
    push_trimmed(trimmed(line.substr(0, end)));
    line.remove_prefix(std::min(end + 1, line.size()));
  }
}

}  // namespace surfaced::io
