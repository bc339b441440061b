#pragma once

#include <chrono>
#include <string>

namespace surfaced {

using SystemTime = std::chrono::sys_time<std::chrono::milliseconds>;

/// Time of day, to the millisecond.
SystemTime now();

/// RFC 3339 in UTC with milliseconds: 2024-05-06T07:08:09.012Z. Texts sort as their times do.
std::string to_rfc3339(SystemTime time);

}  // namespace surfaced
