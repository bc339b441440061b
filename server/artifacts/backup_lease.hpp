// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "base/base.hpp"
#include "base/unique_fd.hpp"

namespace surfaced {

/// Between a backup and those who remove files of the same data folder: while a backup lives, no file goes that a
/// record referred to when it began. Removals need not wait: what they leave is found by the sweeps. A lock of the
/// kernel's on `backup.lock`, so that the end of a process, however it comes, ends its lease.
class BackupLease {
 public:
  /// For a backup, before it reads the records; waits a while for removals that have begun.
  /// @return  not_ready if another backup has it
  static Result<BackupLease> take(const std::filesystem::path& data);

  /// For who removes files that records referred to, after these records are gone, durably: not_ready during a backup.
  static Result<BackupLease> to_remove(const std::filesystem::path& data);

 private:
  explicit BackupLease(UniqueFd fd) : fd_(std::move(fd)) {}
  UniqueFd fd_;
};

}  // namespace surfaced
