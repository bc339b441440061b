// SPDX-License-Identifier: GPL-3.0-or-later
// Lists whose entries commas separate: header fields, parameters, settings.
#pragma once

#include <algorithm>
#include <string_view>

namespace surfaced {

/// Without the blanks and tabs around it, which are the optional whitespace of RFC 9110, 5.6.3.
inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// Takes the next entry off a list, without the blanks around it; it may be empty.
inline std::string_view take_entry(std::string_view& list, char separator = ',') {
  const std::string_view entry = list.substr(0, list.find(separator));
  list.remove_prefix(std::min(list.size(), entry.size() + 1));
  return trimmed(entry);
}

}  // namespace surfaced
