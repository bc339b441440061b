// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/contained_start.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <climits>
#include <csignal>
#include <string>

#include "worker/attempt_protocol.hpp"

namespace surfaced {
namespace {

/// What the new process needs, made before there is one: between the start and the exec it is a copy of one thread of
/// many, and may do nothing but system calls.
struct Start {
  char* const* command;
  char* const* environment;
  int output;
  int messages;
  std::string users;
  std::string groups;
};

bool write_text(const char* file, const char* text, std::size_t size) {
  const int fd = ::open(file, O_WRONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool written = ::write(fd, text, size) == static_cast<ssize_t>(size);
  ::close(fd);
  return written;
}

/// The user that the server is stands there as root, who keeps the power over the namespaces through the exec.
bool map_ids(const Start& start) {
  // The server forbids others to look into it, and its copy along with it; then not even it itself could write these.
  return ::prctl(PR_SET_DUMPABLE, 1) == 0 && write_text("/proc/self/setgroups", "deny", 4) &&
         write_text("/proc/self/uid_map", start.users.data(), start.users.size()) &&
         write_text("/proc/self/gid_map", start.groups.data(), start.groups.size());
}

void reset_signals() {
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  for (int signal = 1; signal < NSIG; ++signal) ::sigaction(signal, &usual, nullptr);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

bool move_descriptor(int from, int to) { return from == to ? ::fcntl(to, F_SETFD, 0) == 0 : ::dup2(from, to) == to; }

bool arrange_descriptors(const Start& start) {
  const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (nothing < 0 || !move_descriptor(nothing, STDIN_FILENO)) return false;
  if (!move_descriptor(start.output, STDOUT_FILENO) || !move_descriptor(start.output, STDERR_FILENO)) return false;
  if (!move_descriptor(start.messages, kMessageDescriptor)) return false;
  // All of the server's own are closed by the exec; this is for what a library may have forgotten.
  ::syscall(SYS_close_range, kMessageDescriptor + 1, UINT_MAX, 0);
  return true;
}

[[noreturn]] void become(const Start& start) {
  if (map_ids(start) && ::setpgid(0, 0) == 0 && arrange_descriptors(start)) {
    reset_signals();
    ::execve(start.command[0], start.command, start.environment);
  }
  ::_exit(kCannotBeContained);
}

}  // namespace

pid_t start_contained(char* const* command, char* const* environment, int output, int messages) {
  const Start start{command,
                    environment,
                    output,
                    messages,
                    "0 " + std::to_string(::geteuid()) + " 1",
                    "0 " + std::to_string(::getegid()) + " 1"};
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  const auto pid = static_cast<pid_t>(::syscall(
      SYS_clone, static_cast<unsigned long>(CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNS | SIGCHLD), 0, 0, 0, 0));
  if (pid == 0) become(start);
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return pid;
}

}  // namespace surfaced
