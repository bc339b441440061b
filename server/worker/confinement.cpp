// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/confinement.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>

#include "platform/files.hpp"
#include "worker/file_access.hpp"
#include "worker/syscall_filter.hpp"

namespace surfaced {
namespace {

constexpr rlim_t kOpenFiles = 64;

// The shadow memory of the sanitizers is data to the kernel, terabytes of it, and the search for leaks traces
// the process from another one.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

Status limit(__rlimit_resource_t resource, rlim_t soft, rlim_t hard, std::string_view name) {
  const rlimit both{soft, hard};
  if (::setrlimit(resource, &both) != 0) return system_error("set the limit of " + std::string(name), errno);
  return Done{};
}

Status set_limits(const AttemptLimits& limits) {
  const auto cpu = static_cast<rlim_t>(limits.time.count()) * std::max(1U, limits.threads);
  if (Status set = limit(RLIMIT_CORE, 0, 0, "core files"); !set.ok()) return set;
  if (Status set = limit(RLIMIT_CPU, cpu, cpu + 5, "processor time"); !set.ok()) return set;
  if (Status set = limit(RLIMIT_FSIZE, limits.file_bytes, limits.file_bytes, "file size"); !set.ok()) return set;
  if (Status set = limit(RLIMIT_NOFILE, kOpenFiles, kOpenFiles, "open files"); !set.ok()) return set;
  if (kSanitized) return Done{};
  return limit(RLIMIT_DATA, limits.memory_bytes, limits.memory_bytes, "memory");
}

}  // namespace

Result<std::string> confine_this_process(const AttemptSpec& spec) {
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) return system_error("die with the server", errno);
  // The server may have died before the line above: then the signal will never come.
  if (::getppid() != spec.parent) return Error{ErrorCode::lost, "the server is gone"};
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return system_error("give up privileges", errno);
  // When the machine runs out of memory the kernel shall take the child, not the server. Best effort: it
  // is no limit, and /proc may be hidden.
  if (const UniqueFd score(::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC)); score) {
    [[maybe_unused]] const Status ignored = write_all(score.get(), as_bytes("500"), "raise the OOM score");
  }
  if (Status set = set_limits(spec.limits); !set.ok()) return set.error();
  const auto files = restrict_files(spec.cloud, spec.directory);
  if (!files) return files.error();
  if (kSanitized) return *files + ", no seccomp under a sanitizer";
  if (Status filtered = restrict_system_calls(); !filtered.ok()) return filtered.error();
  return *files + ", seccomp";
}

}  // namespace surfaced
