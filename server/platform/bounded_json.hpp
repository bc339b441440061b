// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/base.hpp"

namespace surfaced {

/// What JSON of strangers may have. An ordered object is looked through member by member for every name that is added,
/// so its members are what bounds the work; the writer calls itself for every level.
struct JsonBounds {
  std::size_t depth = 64;
  /// Members of one object.
  std::size_t members = 128;
  /// Members and elements in all.
  std::size_t values = 20'000;
};

/// Reads JSON that a client, or a child that may be taken over, has written.
/// @return  invalid_request with what is wrong with the text
/// @cost    at most 30 ns a byte, and once the depth in memory, before the text is known to be within the bounds
Result<nlohmann::ordered_json> parse_bounded(std::string_view text, const JsonBounds& bounds = {});

}  // namespace surfaced
