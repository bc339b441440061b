// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/syscall_filter.hpp"

#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>

#include "platform/files.hpp"

namespace surfaced {
namespace {

// Names that an architecture does not have are skipped.
constexpr auto kAllowed = std::to_array<const char*>(
    {// open files
     "read", "write", "readv", "writev", "pread64", "pwrite64", "preadv", "pwritev", "close", "lseek", "_llseek",
     "fstat", "fstat64", "fcntl", "fcntl64", "fsync", "fdatasync", "ftruncate", "ftruncate64", "fallocate", "fadvise64",
     "dup", "dup2", "dup3", "poll", "ppoll", "flock",
     // files by name: what they reach is Landlock's part
     "open", "openat", "stat", "lstat", "stat64", "newfstatat", "fstatat64", "statx", "access", "faccessat",
     "faccessat2", "readlink", "readlinkat", "getcwd", "getdents64", "rename", "renameat", "renameat2", "unlink",
     "unlinkat", "statfs", "fstatfs",
     // memory
     "brk", "mmap", "mmap2", "munmap", "mremap", "mprotect", "madvise", "membarrier",
     // threads
     "futex", "futex_time64", "futex_waitv", "set_robust_list", "get_robust_list", "rseq", "set_tid_address",
     "sched_yield", "sched_getaffinity", "sched_getparam", "sched_getscheduler", "getcpu", "exit", "exit_group",
     // signals to itself come through tgkill below
     "rt_sigaction", "rt_sigprocmask", "rt_sigreturn", "sigreturn", "sigaltstack", "restart_syscall", "pause",
     // time and numbers
     "clock_gettime", "clock_gettime64", "clock_getres", "clock_nanosleep", "clock_nanosleep_time64", "nanosleep",
     "gettimeofday", "time", "times", "getrusage", "getrandom", "uname", "sysinfo", "getpid", "gettid", "getppid",
     "getuid", "geteuid", "getgid", "getegid", "getrlimit", "ugetrlimit", "arch_prctl"});

/// What only an intruder asks for. Everything that stands on neither list fails with EPERM.
constexpr auto kDeadly = std::to_array<const char*>({"socket",
                                                     "socketpair",
                                                     "connect",
                                                     "bind",
                                                     "listen",
                                                     "accept",
                                                     "accept4",
                                                     "sendto",
                                                     "sendmsg",
                                                     "sendmmsg",
                                                     "execve",
                                                     "execveat",
                                                     "ptrace",
                                                     "process_vm_readv",
                                                     "pidfd_getfd",
                                                     "pidfd_open",
                                                     "process_vm_writev",
                                                     "bpf",
                                                     "io_uring_setup",
                                                     "userfaultfd",
                                                     "mount",
                                                     "umount2",
                                                     "open_tree",
                                                     "move_mount",
                                                     "unshare",
                                                     "setns",
                                                     "chroot",
                                                     "pivot_root",
                                                     "keyctl",
                                                     "add_key",
                                                     "request_key",
                                                     "init_module",
                                                     "finit_module",
                                                     "kexec_load",
                                                     "perf_event_open",
                                                     "open_by_handle_at"});

struct Release {
  void operator()(void* filter) const { seccomp_release(filter); }
};
using Filter = std::unique_ptr<void, Release>;

int add(const Filter& filter, std::uint32_t action, const char* name) {
  const int call = seccomp_syscall_resolve_name(name);
  return call == __NR_SCMP_ERROR ? 0 : seccomp_rule_add(filter.get(), action, call, 0);
}

/// Calls that are harmless only with certain arguments.
int add_conditions(const Filter& filter) {
  const auto allow = [&](const char* name, scmp_arg_cmp condition) {
    return seccomp_rule_add_array(filter.get(), SCMP_ACT_ALLOW, seccomp_syscall_resolve_name(name), 1, &condition);
  };
  const auto same = [](unsigned argument, std::uint64_t value) {
    return scmp_arg_cmp{argument, SCMP_CMP_EQ, value, 0};
  };
  // Threads, but no processes. The arguments of clone3 lie in memory, where a filter cannot look: told that
  // there is none, the C library takes clone.
  int failed = allow("clone", scmp_arg_cmp{0, SCMP_CMP_MASKED_EQ, CLONE_THREAD, CLONE_THREAD});
  if (failed == 0) failed = seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
  if (failed == 0) failed = allow("tgkill", same(0, static_cast<std::uint64_t>(::getpid())));
  if (failed == 0) failed = allow("prlimit64", same(0, 0));
  if (failed == 0) failed = allow("prctl", same(0, PR_SET_NAME));
  // isatty
  if (failed == 0) failed = allow("ioctl", same(1, TCGETS));
  return failed;
}

}  // namespace

Status restrict_system_calls() {
  const Filter filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)));
  if (!filter) return Error{ErrorCode::out_of_memory, "there is no memory for a filter of system calls"};
  int failed = 0;
  for (const char* const name : kAllowed) failed = failed != 0 ? failed : add(filter, SCMP_ACT_ALLOW, name);
  for (const char* const name : kDeadly) failed = failed != 0 ? failed : add(filter, SCMP_ACT_KILL_PROCESS, name);
  if (failed == 0) failed = add_conditions(filter);
  if (failed == 0) failed = seccomp_load(filter.get());
  if (failed == 0) return Done{};
  return Error{ErrorCode::not_ready, "the kernel takes no filter of system calls (seccomp): " + error_text(-failed)};
}

}  // namespace surfaced
