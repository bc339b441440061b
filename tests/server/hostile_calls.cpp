// SPDX-License-Identifier: GPL-3.0-or-later
#include "hostile_calls.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <functional>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include "worker/syscall_rules.hpp"

namespace surfaced::testing {
namespace {

/// What was tried and did not fail.
class Booty {
 public:
  void expect_refused(const std::string& what, long result) {
    if (result >= 0) taken_ += (taken_.empty() ? "" : ", ") + what;
  }
  std::string taken() const { return taken_; }

 private:
  std::string taken_;
};

void signals_by_descriptors(const AttemptSpec& spec, Booty& booty) {
  struct {
    int type;
    int pid;
  } owner{1, spec.parent};
  for (const int fd : {STDOUT_FILENO, kMessageDescriptor}) {
    for (const int whom : {spec.parent, -spec.parent, 1, -1, 0}) {
      booty.expect_refused("F_SETOWN " + std::to_string(whom), ::syscall(SYS_fcntl, fd, F_SETOWN, whom));
    }
    booty.expect_refused("F_SETOWN_EX", ::syscall(SYS_fcntl, fd, 15, &owner));
    booty.expect_refused("F_SETSIG", ::syscall(SYS_fcntl, fd, 10, SIGKILL));
    booty.expect_refused("O_ASYNC", ::syscall(SYS_fcntl, fd, F_SETFL, O_ASYNC));
    // Named by their numbers where headers hide them: F_SETLEASE, F_NOTIFY, F_SETPIPE_SZ, F_ADD_SEALS.
    for (const int command : {F_DUPFD, F_SETLK, F_SETLKW, 1024, 1026, 1031, 1033}) {
      booty.expect_refused("fcntl " + std::to_string(command), ::syscall(SYS_fcntl, fd, command, 0));
    }
    // FIONBIO, FIOASYNC, FIOSETOWN, SIOCSPGRP, TIOCSTI, TIOCSCTTY
    int yes = 1;
    for (const unsigned request : {0x5421U, 0x5452U, 0x8901U, 0x8902U, 0x5412U, 0x540EU}) {
      booty.expect_refused("ioctl " + std::to_string(request), ::syscall(SYS_ioctl, fd, request, &yes));
    }
  }
}

void signals_by_number(const AttemptSpec& spec, Booty& booty) {
  std::array<char, 128> info{};
  for (const int whom : {spec.parent, -spec.parent, 1, -1}) {
    const std::string name = std::to_string(whom);
    booty.expect_refused("kill " + name, ::syscall(SYS_kill, whom, 0));
    booty.expect_refused("tkill " + name, ::syscall(SYS_tkill, whom, 0));
    booty.expect_refused("tgkill " + name, ::syscall(SYS_tgkill, whom, whom, 0));
    booty.expect_refused("rt_sigqueueinfo " + name, ::syscall(SYS_rt_sigqueueinfo, whom, SIGKILL, info.data()));
    booty.expect_refused("setpgid " + name, ::syscall(SYS_setpgid, 0, whom));
  }
  booty.expect_refused("setsid", ::syscall(SYS_setsid));
  booty.expect_refused("timer_create", ::syscall(SYS_timer_create, CLOCK_MONOTONIC, info.data(), info.data()));
}

void other_processes(const AttemptSpec& spec, Booty& booty) {
  rlimit unlimited{RLIM_INFINITY, RLIM_INFINITY};
  std::array<char, 1024> memory{};
  timespec time{};
  for (const int whom : {spec.parent, 1}) {
    booty.expect_refused("limits of another", ::syscall(SYS_prlimit64, whom, RLIMIT_NOFILE, nullptr, &unlimited));
    booty.expect_refused("affinity of another", ::syscall(SYS_sched_getaffinity, whom, memory.size(), memory.data()));
    booty.expect_refused("scheduler of another", ::syscall(SYS_sched_setscheduler, whom, SCHED_IDLE, memory.data()));
    booty.expect_refused("priority of another", ::syscall(SYS_setpriority, PRIO_PROCESS, whom, 19));
    booty.expect_refused("robust list of another", ::syscall(SYS_get_robust_list, whom, memory.data(), memory.data()));
    const auto clock = static_cast<unsigned>(~whom) << 3U | 2U;
    booty.expect_refused("clock of another", ::syscall(SYS_clock_gettime, clock, &time));
  }
  booty.expect_refused("own limit raised", ::syscall(SYS_prlimit64, 0, RLIMIT_DATA, &unlimited, nullptr));
  booty.expect_refused("own limit set", ::syscall(SYS_setrlimit, RLIMIT_FSIZE, &unlimited));
  booty.expect_refused("fork", ::syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0));
  constexpr unsigned long kThread = CLONE_VM | CLONE_THREAD | CLONE_SIGHAND;
  for (const int more : {CLONE_NEWUSER, CLONE_PARENT, CLONE_PTRACE, CLONE_UNTRACED, CLONE_PIDFD}) {
    booty.expect_refused("thread with " + std::to_string(more),
                         ::syscall(SYS_clone, kThread | static_cast<unsigned long>(more), 0, 0, 0, 0));
  }
  booty.expect_refused("clone3", ::syscall(SYS_clone3, memory.data(), 88));
}

void privileges(Booty& booty) {
  std::array<char, 64> memory{};
  for (int option = 1; option < 100; ++option) {
    if (option == PR_SET_NAME) continue;
    booty.expect_refused("prctl " + std::to_string(option), ::syscall(SYS_prctl, option, 0, memory.data(), 0, 0));
  }
  for (const long call :
       {SYS_setuid,        SYS_setgid,        SYS_setgroups, SYS_capset,    SYS_personality,    SYS_acct,
        SYS_reboot,        SYS_sethostname,   SYS_syslog,    SYS_swapon,    SYS_quotactl,       SYS_memfd_create,
        SYS_eventfd2,      SYS_shmget,        SYS_msgget,    SYS_semget,    SYS_mq_open,        SYS_inotify_init1,
        SYS_fanotify_init, SYS_epoll_create1, SYS_pipe2,     SYS_signalfd4, SYS_timerfd_create, SYS_setitimer,
        SYS_membarrier,    SYS_ioprio_set,    SYS_seccomp,   SYS_mlockall,  SYS_sched_setattr,  SYS_vfork}) {
    booty.expect_refused("call " + std::to_string(call), ::syscall(call, 0, 0, 0, 0, 0, 0));
  }
  int lock = 0;
  for (const int operation : {FUTEX_LOCK_PI, FUTEX_TRYLOCK_PI, FUTEX_UNLOCK_PI, FUTEX_CMP_REQUEUE_PI}) {
    booty.expect_refused("futex " + std::to_string(operation),
                         ::syscall(SYS_futex, &lock, operation, 0, nullptr, &lock, 0));
  }
}

void memory(const AttemptSpec& spec, Booty& booty) {
  constexpr std::size_t kPage = 4096;
  const auto map = [&](const std::string& what, int protection, int flags, int fd = -1) {
    booty.expect_refused(what, ::syscall(SYS_mmap, nullptr, kPage, protection, flags, fd, 0));
  };
  map("memory to execute", PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS);
  map("memory to write and execute", PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS);
  map("locked memory", PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_LOCKED);
  map("huge pages", PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_HUGETLB);
  const int file = ::open((spec.directory / "map").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  map("a file written through memory", PROT_READ | PROT_WRITE, MAP_SHARED, file);
  ::close(file);
  void* const page = ::mmap(nullptr, kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  booty.expect_refused("mprotect to execute", ::syscall(SYS_mprotect, page, kPage, PROT_READ | PROT_EXEC));
  booty.expect_refused("pkey_mprotect", ::syscall(SYS_pkey_mprotect, page, kPage, PROT_READ | PROT_EXEC, -1));
  // MADV_REMOVE, DONTFORK, MERGEABLE, COLD, PAGEOUT, HWPOISON, SOFT_OFFLINE
  for (const int advice : {9, 10, 12, 20, 21, 100, 101}) {
    booty.expect_refused("madvise " + std::to_string(advice), ::syscall(SYS_madvise, page, kPage, advice));
  }
}

void files(const AttemptSpec& spec, Booty& booty) {
  const std::string parent = "/proc/" + std::to_string(spec.parent);
  for (const std::string& path : {std::string("/"), std::string("/etc/passwd"), std::string("/proc/self/mem"),
                                  std::string("/dev/mem"), parent + "/mem", parent + "/environ"}) {
    booty.expect_refused("O_PATH " + path, ::open(path.c_str(), O_PATH | O_CLOEXEC));
    booty.expect_refused("open " + path, ::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  }
  const std::string own = (spec.directory / "own").string();
  booty.expect_refused("O_TMPFILE", ::open(spec.directory.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600));
  booty.expect_refused("a file of root's rights", ::open(own.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 04755));
  const char* const path = own.c_str();
  booty.expect_refused("mkdir", ::syscall(SYS_mkdirat, AT_FDCWD, path, 0700));
  booty.expect_refused("symlink", ::syscall(SYS_symlinkat, "/etc/passwd", AT_FDCWD, path));
  booty.expect_refused("link", ::syscall(SYS_linkat, AT_FDCWD, spec.cloud.c_str(), AT_FDCWD, path, 0));
  booty.expect_refused("mknod", ::syscall(SYS_mknodat, AT_FDCWD, path, S_IFIFO | 0600, 0));
  booty.expect_refused("chmod", ::syscall(SYS_fchmodat, AT_FDCWD, spec.directory.c_str(), 0777));
  booty.expect_refused("chown", ::syscall(SYS_fchownat, AT_FDCWD, spec.directory.c_str(), 0, 0, 0));
  booty.expect_refused("fallocate", ::syscall(SYS_fallocate, STDOUT_FILENO, 0, 0, 1 << 30));
  booty.expect_refused("chdir", ::syscall(SYS_chdir, "/"));
  booty.expect_refused("the cloud written", ::open(spec.cloud.c_str(), O_WRONLY | O_CLOEXEC));
}

/// Calls that end or stall whoever makes them are left out, but for one seed of 16, which shall end itself.
std::vector<long> callable(bool any) {
  std::set<long> left_out{SYS_exit_group, SYS_exit, SYS_rt_sigreturn};
  for (const SyscallRule& deadly : deadly_calls()) left_out.insert(seccomp_syscall_resolve_name(deadly.name));
  if (!any)
    left_out.insert(
        {SYS_munmap, SYS_mremap, SYS_mmap, SYS_brk, SYS_mprotect, SYS_madvise, SYS_rt_sigaction, SYS_tgkill});
  std::vector<long> calls;
  for (long call = 0; call < 480; ++call) {
    if (!left_out.contains(call)) calls.push_back(call);
  }
  return calls;
}

/// Arguments that mean harm to some call or other.
class Arguments {
 public:
  Arguments(const AttemptSpec& spec, std::uint64_t seed)
      : random_(seed), path_("/proc/" + std::to_string(spec.parent)) {
    const auto parent = static_cast<std::uint64_t>(spec.parent);
    pool_ = {0,
             1,
             2,
             3,
             4,
             8,
             9,
             10,
             15,
             1024,
             4096,
             0x2000,
             0x5452,
             0x8901,
             0x8902,
             ~std::uint64_t{0},
             parent,
             ~parent + 1,
             std::uint64_t{1} << 31,
             std::uint64_t{1} << 63,
             std::uint64_t{1} << 40,
             reinterpret_cast<std::uint64_t>(path_.c_str()),
             reinterpret_cast<std::uint64_t>(memory_.data()),
             reinterpret_cast<std::uint64_t>(spec.directory.c_str()),
             reinterpret_cast<std::uint64_t>(&pool_)};
    for (std::uint64_t& each : memory_) each = pool_[random_() % pool_.size()];
  }
  std::uint64_t next() { return random_() % 8 == 0 ? random_() : pool_[random_() % pool_.size()]; }
  long call(const std::vector<long>& calls) { return calls[random_() % calls.size()]; }

 private:
  std::mt19937_64 random_;
  std::string path_;
  std::array<std::uint64_t, 64> memory_{};
  std::vector<std::uint64_t> pool_;
};

}  // namespace

std::string reach_out(const AttemptSpec& spec) {
  Booty booty;
  signals_by_descriptors(spec, booty);
  signals_by_number(spec, booty);
  other_processes(spec, booty);
  privileges(booty);
  memory(spec, booty);
  files(spec, booty);
  return booty.taken();
}

bool sees_other_files() {
  struct stat status {};
  return ::stat("/etc/passwd", &status) == 0 || ::stat("/proc/1", &status) == 0;
}

void call_anything(const AttemptSpec& spec, std::uint64_t seed) {
  const std::vector<long> calls = callable(seed % 16 == 0);
  // Some calls never return: each thread stands for one of them at the end.
  std::vector<std::thread> threads;
  for (std::uint64_t i = 0; i < 24; ++i) {
    threads.emplace_back([&spec, &calls, seed, i] {
      Arguments arguments(spec, seed * 1000 + i);
      for (;;) {
        const long call = arguments.call(calls);
        ::syscall(call, arguments.next(), arguments.next(), arguments.next(), arguments.next(), arguments.next(),
                  arguments.next());
      }
    });
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  ::_exit(0);
}

void call_by_name(const std::string& name) { ::syscall(seccomp_syscall_resolve_name(name.c_str()), 0, 0, 0, 0, 0, 0); }

}  // namespace surfaced::testing
