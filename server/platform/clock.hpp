// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace surfaced {

using SystemTime = std::chrono::sys_time<std::chrono::milliseconds>;

/// Time of day, to the millisecond.
SystemTime now();

/// RFC 3339 in UTC with milliseconds: 2024-05-06T07:08:09.012Z. Texts sort as their times do.
std::string to_rfc3339(SystemTime time);

/// As HTTP writes it: Mon, 06 May 2024 07:08:09 GMT.
std::string to_http_date(SystemTime time);

/// Reads a time as RFC 3339 allows it: with or without a fraction of the second, in UTC or with an offset.
std::optional<SystemTime> parse_rfc3339(std::string_view text);

/// Reads what to_rfc3339 wrote.
SystemTime from_rfc3339(std::string_view text);

}  // namespace surfaced
