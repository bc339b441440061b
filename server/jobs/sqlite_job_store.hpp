// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "jobs/job_store.hpp"

namespace surfaced {

struct JobStoreLimits {
  /// Jobs that may wait at once.
  std::size_t queue = 1000;
  /// How long an id answers "gone" after its job was removed.
  std::chrono::seconds tombstone = std::chrono::hours(24);
  /// A claim that was not renewed for this long is void.
  std::chrono::milliseconds lease{30'000};
  /// How long a call waits while another process holds the store.
  std::chrono::milliseconds patience{2'000};
};

/// Opens or creates the job store in this file. One server uses it at a time (the data directory is
/// locked before).
/// @return internal_error if SQLite cannot open it or a newer surfaced has written it.
Result<std::unique_ptr<JobStore>> open_sqlite_job_store(const std::filesystem::path& file,
                                                        const JobStoreLimits& limits);

}  // namespace surfaced
