// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/accept.hpp"

#include <algorithm>
#include <optional>

#include "base/text.hpp"
#include "http/message.hpp"
#include "platform/lists.hpp"

namespace surfaced::http {
namespace {

/// 0, 0.5, 1.000 and the like, in thousandths.
std::optional<int> parse_quality(std::string_view text) {
  if (text.empty() || text.size() > 5 || (text[0] != '0' && text[0] != '1')) return std::nullopt;
  int value = (text[0] - '0') * 1000;
  if (text.size() > 1 && text[1] != '.') return std::nullopt;
  int unit = 100;
  for (const char c : text.substr(std::min<std::size_t>(text.size(), 2))) {
    if (c < '0' || c > '9') return std::nullopt;
    value += (c - '0') * unit;
    unit /= 10;
  }
  return value <= 1000 ? std::optional(value) : std::nullopt;
}

}  // namespace

std::vector<MediaRange> parse_accept(std::string_view value) {
  // More than any client names; what stands behind them is not read.
  constexpr std::size_t kMostRanges = 256;
  std::vector<MediaRange> ranges;
  for (std::size_t i = 0; i < kMostRanges && !value.empty(); ++i) {
    std::string_view item = take_entry(value, ',');
    std::string_view name = take_entry(item, ';');
    MediaRange range;
    range.type = in_lower_case(take_entry(name, '/'));
    range.subtype = in_lower_case(name);
    bool readable = !range.type.empty() && !range.subtype.empty();
    while (!item.empty()) {
      std::string_view parameter = take_entry(item, ';');
      if (!same_name(take_entry(parameter, '='), "q")) continue;
      const auto quality = parse_quality(parameter);
      readable &= quality.has_value();
      range.quality = quality.value_or(0);
    }
    if (readable) ranges.push_back(std::move(range));
  }
  return ranges;
}

int quality_of(const std::vector<MediaRange>& ranges, std::string_view media_type) {
  const std::string_view type = media_type.substr(0, media_type.find('/'));
  std::string_view subtype = media_type.substr(std::min(media_type.size(), type.size() + 1));
  subtype = subtype.substr(0, subtype.find(';'));
  int best_rank = 0;
  int quality = 0;
  for (const MediaRange& range : ranges) {
    int rank = 0;
    if (range.type == type && range.subtype == subtype) {
      rank = 3;
    } else if (range.type == type && range.subtype == "*") {
      rank = 2;
    } else if (range.type == "*" && range.subtype == "*") {
      rank = 1;
    }
    if (rank > best_rank) {
      best_rank = rank;
      quality = range.quality;
    }
  }
  return quality;
}

}  // namespace surfaced::http
