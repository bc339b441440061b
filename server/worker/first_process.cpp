// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/first_process.hpp"

#include <fcntl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>

#include "platform/files.hpp"
#include "worker/contained_start.hpp"
#include "worker/file_access.hpp"
#include "worker/private_root.hpp"

namespace surfaced {
namespace {

/// In a user namespace root has no power over files of users that are not in it.
bool reaches(const AttemptSpec& spec) {
  return ::access(spec.cloud.c_str(), R_OK) == 0 && ::access(spec.directory.c_str(), R_OK | W_OK | X_OK) == 0;
}

[[noreturn]] void wait_for(pid_t worker) {
  // A pipe ends for the server when the work has closed it.
  ::syscall(SYS_close_range, 0U, UINT_MAX, 0U);
  for (;;) {
    int status = 0;
    const pid_t ended = ::waitpid(-1, &status, 0);
    if (ended < 0 && errno != EINTR) ::_exit(kCannotBeContained);
    if (ended != worker) continue;
    if (WIFSIGNALED(status)) ::_exit(kEndedBySignal + WTERMSIG(status));
    ::_exit(std::min(WEXITSTATUS(status), kPathsNotReached - 1));
  }
}

}  // namespace

bool is_first_process() { return ::getpid() == 1; }

Result<std::string> continue_behind_first_process(const AttemptSpec& spec) {
  if (!reaches(spec)) ::_exit(kPathsNotReached);
  const std::array places{VisiblePlace{spec.cloud, false}, VisiblePlace{spec.directory, true},
                          VisiblePlace{kProcessors, false}};
  const bool hidden = hide_all_but(places);
  const pid_t worker = ::fork();
  if (worker < 0) return system_error("start the work", errno);
  if (worker > 0) wait_for(worker);
  return std::string(hidden ? "namespaces of user, PID and mount" : "namespaces of user and PID");
}

}  // namespace surfaced
