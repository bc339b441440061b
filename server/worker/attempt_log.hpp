// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "base/base.hpp"
#include "base/unique_fd.hpp"

namespace surfaced {

/// log.txt of an attempt: lines of the server, and what the child says, up to a limit.
class AttemptLog {
 public:
  static Result<AttemptLog> create(const std::filesystem::path& file);
  /// A log that goes on elsewhere.
  static AttemptLog onto(UniqueFd fd) { return AttemptLog(std::move(fd)); }

  /// A line of the server, with the time before it.
  void line(std::string_view text);

  /// Bytes of the child; what exceeds the limit is counted, not kept.
  void child_output(std::string_view bytes);

  /// Says how much was left out, if anything was.
  void close();

 private:
  explicit AttemptLog(UniqueFd fd) : fd_(std::move(fd)) {}
  void write(std::string_view bytes);

  UniqueFd fd_;
  std::uint64_t child_bytes_ = 0;
  std::uint64_t dropped_ = 0;
  bool line_open_ = false;
};

}  // namespace surfaced
