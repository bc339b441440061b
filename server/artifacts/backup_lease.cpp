// SPDX-License-Identifier: GPL-3.0-or-later
#include "artifacts/backup_lease.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <chrono>
#include <thread>

#include "observability/log.hpp"
#include "platform/files.hpp"

namespace surfaced {
namespace {

/// A removal holds it for as long as a few files take.
constexpr std::chrono::seconds kLeasePatience{10};
constexpr std::chrono::milliseconds kLeasePause{2};

Result<UniqueFd> open_lock(const std::filesystem::path& data) {
  UniqueFd fd(::open((data / "backup.lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!fd) return system_error("open backup.lock", errno);
  return fd;
}

}  // namespace

Result<BackupLease> BackupLease::take(const std::filesystem::path& data) {
  auto fd = open_lock(data);
  if (!fd) return std::move(fd).error();
  const auto deadline = std::chrono::steady_clock::now() + kLeasePatience;
  while (::flock(fd->get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return system_error("lock backup.lock", errno);
    if (std::chrono::steady_clock::now() > deadline) {
      return Error{ErrorCode::not_ready, "another backup of " + data.string() + " is being made"};
    }
    std::this_thread::sleep_for(kLeasePause);
  }
  return BackupLease(std::move(*fd));
}

Result<BackupLease> BackupLease::to_remove(const std::filesystem::path& data) {
  const auto refused = [](Error error) {
    log(LogLevel::error, "nothing can be removed: " + error.detail);
    return error;
  };
  auto fd = open_lock(data);
  if (!fd) return refused(fd.error());
  if (::flock(fd->get(), LOCK_SH | LOCK_NB) == 0) return BackupLease(std::move(*fd));
  if (errno != EWOULDBLOCK) return refused(system_error("lock backup.lock", errno));
  return Error{ErrorCode::not_ready, "a backup is being made"};
}

}  // namespace surfaced
