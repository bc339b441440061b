// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/confinement.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>

#include "platform/files.hpp"
#include "worker/attempt_bounds.hpp"
#include "worker/file_access.hpp"
#include "worker/first_process.hpp"
#include "worker/privileges.hpp"
#include "worker/sanitizers.hpp"
#include "worker/syscall_filter.hpp"

namespace surfaced {
namespace {

constexpr rlim_t kOpenFiles = 64;

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

/// The server holds the other end of the pipe for as long as it lives. From a PID namespace it cannot be seen.
bool server_lives(const AttemptSpec& spec) {
  pollfd pipe{kMessageDescriptor, 0, 0};
  if (is_first_process()) return ::poll(&pipe, 1, 0) == 0;
  return ::getppid() == spec.parent;
}

Status die_with_the_server(const AttemptSpec& spec) {
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) return system_error("die with the server", errno);
  // It may have died before the line above: then the signal will never come.
  if (!server_lives(spec)) return Error{ErrorCode::lost, "the server is gone"};
  return Done{};
}

/// When the machine runs out of memory the kernel shall take the child, not the server. Best effort: it is no limit,
/// and /proc may be hidden.
void offer_itself_to_the_kernel() {
  if (const UniqueFd score(::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC)); score) {
    [[maybe_unused]] const Status ignored = write_all(score.get(), as_bytes("500"), "raise the OOM score");
  }
}

/// A user who is alone in a namespace is counted alone. Root is not held to this limit; the server counts then.
Status limit_threads(const AttemptLimits& limits) {
  const rlim_t most = most_threads(limits) + 1;
  return limit(RLIMIT_NPROC, most, most, "threads");
}

}  // namespace

Result<std::string> confine_this_process(const AttemptSpec& spec) {
  if (Status tied = die_with_the_server(spec); !tied.ok()) return tied.error();
  offer_itself_to_the_kernel();
  std::string in_force = "no namespaces";
  if (is_first_process()) {
    auto namespaces = continue_behind_first_process(spec);
    if (!namespaces) return namespaces;
    in_force = std::move(*namespaces);
    if (Status set = limit_threads(spec.limits); !set.ok()) return set.error();
  }
  const auto capabilities = drop_capabilities(spec.cloud, spec.directory);
  if (!capabilities) return capabilities;
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return system_error("give up privileges", errno);
  if (Status set = set_limits(spec.limits); !set.ok()) return set.error();
  const auto files = restrict_files(spec.cloud, spec.directory);
  if (!files) return files;
  in_force += ", " + *capabilities + ", " + *files;
  if (kSanitized) return in_force + ", no seccomp under a sanitizer";
  if (Status filtered = restrict_system_calls(); !filtered.ok()) return filtered.error();
  return in_force + ", seccomp";
}

}  // namespace surfaced
