// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: where a result comes from and what it cost.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// Lower-case hexadecimal SHA-256 of a file.
Result<std::string> digest_of(const std::filesystem::path& path);

/// What this process has used so far.
struct Resources {
  double cpu_seconds = 0;
  std::uint64_t peak_rss_bytes = 0;
};
Resources resources_used();

}  // namespace surfaced
