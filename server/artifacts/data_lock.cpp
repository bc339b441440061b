// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <chrono>
#include <thread>

#include "artifacts/file_artifact_store.hpp"
#include "platform/files.hpp"

namespace surfaced {
namespace {

/// A child that was being started when its server was killed holds the lock until its exec.
constexpr std::chrono::milliseconds kLockPatience{1000};
constexpr std::chrono::milliseconds kLockPause{10};

/// 0, or the error number.
int lock_soon(int fd) {
  const auto deadline = std::chrono::steady_clock::now() + kLockPatience;
  while (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK || std::chrono::steady_clock::now() > deadline) return errno;
    std::this_thread::sleep_for(kLockPause);
  }
  return 0;
}

}  // namespace

Result<DataLock> DataLock::acquire(const std::filesystem::path& directory) {
  if (Status made = make_directory(directory); !made.ok()) {
    return Error{ErrorCode::output_not_writable, "--data " + directory.string() + ": " + made.error().detail};
  }
  UniqueFd fd(::open((directory / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!fd) {
    return Error{ErrorCode::output_not_writable, "--data " + directory.string() + ": " + error_text(errno)};
  }
  if (const int failed = lock_soon(fd.get()); failed != 0) {
    if (failed != EWOULDBLOCK) return system_error("lock " + directory.string(), failed);
    return Error{ErrorCode::invalid_usage,
                 "--data " + directory.string() + " is in use by another surfaced; stop it or give another directory"};
  }
  return DataLock(std::move(fd));
}

}  // namespace surfaced
