// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/base.hpp"

namespace surfaced {

/// A file of a data folder as the records describe it.
struct RecordedFile {
  /// Below the folder.
  std::filesystem::path path;
  std::uint64_t bytes = 0;
  /// Empty for an unfinished upload, whose hash nobody knows yet, and of which more than `bytes` may be there.
  std::string sha256;
};

/// What the records of a job store refer to.
struct Recorded {
  std::string store;
  std::uint64_t jobs = 0;
  std::uint64_t clouds = 0;
  std::uint64_t uploads = 0;
  std::vector<RecordedFile> files;
};

/// Copies the job store as it is at one moment into a new file, while a server uses it.
/// @return  invalid_usage if there is none, or another version of surfaced has made it
Status copy_records(const std::filesystem::path& from, const std::filesystem::path& to);

/// Reads the records of a copy that nobody uses; changes nothing, also not beside the file.
Result<Recorded> read_records(const std::filesystem::path& copy);

/// What is wrong inside of a copy that nobody uses: what SQLite's own check finds, and counters that do not agree with
/// what they count.
Result<std::vector<std::string>> check_records(const std::filesystem::path& copy);

}  // namespace surfaced
