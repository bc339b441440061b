// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/syscall_filter.hpp"

#include <seccomp.h>

#include <cerrno>
#include <memory>

#include "platform/files.hpp"
#include "worker/syscall_rules.hpp"

namespace surfaced {
namespace {

struct Release {
  void operator()(void* filter) const { seccomp_release(filter); }
};
using Filter = std::unique_ptr<void, Release>;

/// Names that an architecture does not have are skipped.
int add(const Filter& filter, std::uint32_t action, const SyscallRule& rule) {
  const int call = seccomp_syscall_resolve_name(rule.name);
  if (call == __NR_SCMP_ERROR) return 0;
  return seccomp_rule_add_array(filter.get(), action, call, static_cast<unsigned>(rule.arguments.size()),
                                rule.arguments.data());
}

int add_all(const Filter& filter, std::uint32_t action, const std::vector<SyscallRule>& rules) {
  for (const SyscallRule& rule : rules) {
    if (const int failed = add(filter, action, rule); failed != 0) return failed;
  }
  return 0;
}

int load_filter(const Filter& filter) {
  // Of the other numberings of calls that the processor has (32 bits, x32).
  if (const int failed = seccomp_attr_set(filter.get(), SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS); failed != 0) {
    return failed;
  }
  if (const int failed = add_all(filter, SCMP_ACT_ALLOW, allowed_calls()); failed != 0) return failed;
  if (const int failed = add_all(filter, SCMP_ACT_KILL_PROCESS, deadly_calls()); failed != 0) return failed;
  // The arguments of clone3 lie in memory, where a filter cannot look: told that there is none, the C library takes
  // clone.
  if (const int failed = add(filter, SCMP_ACT_ERRNO(ENOSYS), {"clone3", {}}); failed != 0) return failed;
  return seccomp_load(filter.get());
}

}  // namespace

Status restrict_system_calls() {
  const Filter filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)));
  if (!filter) return Error{ErrorCode::out_of_memory, "there is no memory for a filter of system calls"};
  const int failed = load_filter(filter);
  if (failed == 0) return Done{};
  return Error{ErrorCode::not_ready, "the kernel takes no filter of system calls (seccomp): " + error_text(-failed)};
}

}  // namespace surfaced
