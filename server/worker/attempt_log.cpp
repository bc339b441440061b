// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/attempt_log.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <string>

#include "platform/clock.hpp"
#include "platform/files.hpp"

namespace surfaced {
namespace {

constexpr std::uint64_t kMaxChildBytes = std::uint64_t{1} << 20;

}  // namespace

Result<AttemptLog> AttemptLog::create(const std::filesystem::path& file) {
  UniqueFd fd(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0600));
  if (!fd) return system_error("create the log of an attempt", errno);
  return AttemptLog(std::move(fd));
}

void AttemptLog::line(std::string_view text) {
  if (line_open_) write("\n");
  line_open_ = false;
  write(to_rfc3339(now()) + " " + std::string(text) + "\n");
}

void AttemptLog::child_output(std::string_view bytes) {
  const auto kept = std::min<std::uint64_t>(bytes.size(), kMaxChildBytes - child_bytes_);
  dropped_ += bytes.size() - kept;
  child_bytes_ += kept;
  if (kept == 0) return;
  bytes = bytes.substr(0, kept);
  write(bytes);
  line_open_ = bytes.back() != '\n';
}

void AttemptLog::close() {
  if (dropped_ == 0) return;
  line(std::to_string(dropped_) + " bytes of output were left out; the limit is " + std::to_string(kMaxChildBytes));
}

void AttemptLog::write(std::string_view bytes) {
  // A log that cannot be written (disk full) must not fail the attempt; publishing will notice.
  [[maybe_unused]] const Status ignored = write_all(fd_.get(), as_bytes(bytes), "write the log");
}

}  // namespace surfaced
