// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/syscall_rules.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <initializer_list>

namespace surfaced {
namespace {

using Rules = std::vector<SyscallRule>;

scmp_arg_cmp equals(unsigned argument, std::uint64_t value) { return {argument, SCMP_CMP_EQ, value, 0}; }
scmp_arg_cmp at_most(unsigned argument, std::uint64_t value) { return {argument, SCMP_CMP_LE, value, 0}; }

/// All bits of `must`, any of `may`, no others.
scmp_arg_cmp bits(unsigned argument, std::uint64_t must, std::uint64_t may) {
  return {argument, SCMP_CMP_MASKED_EQ, ~(may & ~must), must};
}
scmp_arg_cmp without_bits(unsigned argument, std::uint64_t forbidden) {
  return {argument, SCMP_CMP_MASKED_EQ, forbidden, 0};
}

void add_any_arguments(Rules& rules, std::initializer_list<const char*> names) {
  for (const char* const name : names) rules.push_back({name, {}});
}

void add_files(Rules& rules) {
  add_any_arguments(rules,
                    {"read", "write", "readv", "writev", "pread64", "pwrite64", "close", "lseek", "_llseek", "fstat",
                     "fstat64", "fsync", "fdatasync", "ftruncate", "ftruncate64", "poll", "ppoll", "getdents64",
                     // By name: what can be opened, renamed and removed is Landlock's part; what can be named at all,
                     // that of the mount namespace, where there is one.
                     "stat", "lstat", "stat64", "newfstatat", "fstatat64", "rename", "renameat", "unlink", "unlinkat"});
  // No handles on what may not be read (O_PATH), no files without a name, which nobody could count (O_TMPFILE), and
  // none that would run with their owner's rights. The C library opens everything by openat.
  constexpr std::uint64_t kNameless = 020000000;
  rules.push_back({"openat", {without_bits(2, O_PATH | kNameless), without_bits(3, 07000)}});
  // Not F_SETOWN, F_SETSIG and O_ASYNC, by which the kernel sends signals to anybody; nor leases, seals and sizes of
  // pipes.
  for (const char* const name : {"fcntl", "fcntl64"}) {
    for (const int command : {F_GETFD, F_SETFD, F_GETFL}) {
      rules.push_back({name, {equals(1, static_cast<std::uint64_t>(command))}});
    }
  }
  // isatty
  rules.push_back({"ioctl", {equals(1, TCGETS)}});
}

void add_memory(Rules& rules) {
  add_any_arguments(rules, {"brk", "munmap", "mremap"});
  // Nothing that can be executed, nothing that is locked in memory, and no file that is written through memory, where
  // no limit of files counts.
  constexpr std::uint64_t kData = PROT_READ | PROT_WRITE;
  constexpr std::uint64_t kHarmless =
      MAP_FIXED | MAP_FIXED_NOREPLACE | MAP_NORESERVE | MAP_STACK | MAP_POPULATE | MAP_DENYWRITE;
  for (const char* const name : {"mmap", "mmap2"}) {
    rules.push_back({name, {bits(2, 0, kData), bits(3, MAP_PRIVATE, kHarmless | MAP_ANONYMOUS)}});
    rules.push_back({name, {bits(2, 0, kData), bits(3, MAP_SHARED | MAP_ANONYMOUS, kHarmless)}});
  }
  rules.push_back({"mprotect", {bits(2, 0, kData)}});
  rules.push_back({"madvise", {at_most(2, MADV_DONTNEED)}});
  for (const int advice : {MADV_FREE, MADV_HUGEPAGE, MADV_NOHUGEPAGE}) {
    rules.push_back({"madvise", {equals(2, static_cast<std::uint64_t>(advice))}});
  }
}

void add_threads(Rules& rules) {
  add_any_arguments(rules, {"set_robust_list", "rseq", "sched_yield", "getcpu", "exit", "exit_group"});
  // Threads, but no processes, and nothing of the kinds that come with later kernels.
  constexpr std::uint64_t kThread = CLONE_VM | CLONE_THREAD | CLONE_SIGHAND;
  constexpr std::uint64_t kUsual =
      CLONE_FS | CLONE_FILES | CLONE_SYSVSEM | CLONE_SETTLS | CLONE_PARENT_SETTID | CLONE_CHILD_CLEARTID;
  rules.push_back({"clone", {bits(0, kThread, kUsual)}});
  // Not those that inherit priorities, whose code in the kernel has been a way out before.
  for (const char* const name : {"futex", "futex_time64"}) {
    for (const int operation : {FUTEX_WAIT, FUTEX_WAKE, FUTEX_REQUEUE, FUTEX_CMP_REQUEUE, FUTEX_WAKE_OP,
                                FUTEX_WAIT_BITSET, FUTEX_WAKE_BITSET}) {
      rules.push_back(
          {name, {bits(1, static_cast<std::uint64_t>(operation), FUTEX_PRIVATE_FLAG | FUTEX_CLOCK_REALTIME)}});
    }
  }
  const auto self = static_cast<std::uint64_t>(::getpid());
  for (const std::uint64_t process : {std::uint64_t{0}, self}) {
    for (const char* const name : {"sched_getaffinity", "sched_getparam", "sched_getscheduler"}) {
      rules.push_back({name, {equals(0, process)}});
    }
  }
  rules.push_back({"prctl", {equals(0, PR_SET_NAME)}});
}

void add_signals_to_itself(Rules& rules) {
  add_any_arguments(rules, {"rt_sigaction", "rt_sigprocmask", "rt_sigreturn", "sigreturn", "sigaltstack",
                            "restart_syscall", "pause"});
  rules.push_back({"tgkill", {equals(0, static_cast<std::uint64_t>(::getpid()))}});
}

void add_time_and_numbers(Rules& rules) {
  add_any_arguments(rules, {"nanosleep", "gettimeofday", "time", "times", "getrusage", "getrandom", "uname", "sysinfo",
                            "getpid", "gettid", "getppid", "getuid", "geteuid", "getgid", "getegid"});
  // Other numbers stand for the clocks of other processes.
  constexpr std::uint64_t kLastClock = 11;
  for (const char* const name :
       {"clock_gettime", "clock_gettime64", "clock_getres", "clock_nanosleep", "clock_nanosleep_time64"}) {
    rules.push_back({name, {at_most(0, kLastClock)}});
  }
  // To ask for its own limits, and to lower that of its memory once it knows its cloud: without capabilities nothing
  // raises a hard limit.
  rules.push_back({"prlimit64", {equals(0, 0), equals(2, 0)}});
  rules.push_back({"prlimit64", {equals(0, 0), equals(1, RLIMIT_DATA)}});
  add_any_arguments(rules, {"getrlimit", "ugetrlimit"});
}

}  // namespace

std::vector<SyscallRule> allowed_calls() {
  Rules rules;
  add_files(rules);
  add_memory(rules);
  add_threads(rules);
  add_signals_to_itself(rules);
  add_time_and_numbers(rules);
  return rules;
}

std::vector<SyscallRule> deadly_calls() {
  Rules rules;
  add_any_arguments(rules, {"socket",
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
                            "process_vm_writev",
                            "pidfd_getfd",
                            "pidfd_open",
                            "pidfd_send_signal",
                            "bpf",
                            "io_uring_setup",
                            "io_uring_enter",
                            "io_uring_register",
                            "userfaultfd",
                            "mount",
                            "umount2",
                            "open_tree",
                            "move_mount",
                            "fsopen",
                            "fsmount",
                            "fspick",
                            "mount_setattr",
                            "unshare",
                            "setns",
                            "chroot",
                            "pivot_root",
                            "keyctl",
                            "add_key",
                            "request_key",
                            "init_module",
                            "finit_module",
                            "delete_module",
                            "kexec_load",
                            "kexec_file_load",
                            "perf_event_open",
                            "open_by_handle_at",
                            "process_madvise",
                            "kcmp"});
  return rules;
}

}  // namespace surfaced
