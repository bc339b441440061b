// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace surfaced::http {

/// One range of an Accept header, RFC 9110 §12.5.1; in lower case.
struct MediaRange {
  std::string type;
  std::string subtype;
  /// Thousandths, 0 to 1000; 0 refuses.
  int quality = 1000;
};

/// Reads an Accept header; ranges that break the rules are left out, as are their parameters but q, and what stands
/// behind the first 256.
std::vector<MediaRange> parse_accept(std::string_view value);

/// How much a media type is wanted, in thousandths: the quality of the most specific range that fits, 0 if none does.
int quality_of(const std::vector<MediaRange>& ranges, std::string_view media_type);

}  // namespace surfaced::http
