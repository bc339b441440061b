// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/child_process.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <utility>
#include <vector>

#include "platform/files.hpp"
#include "worker/attempt_protocol.hpp"

namespace surfaced {
namespace {

struct Pipe {
  UniqueFd read;
  UniqueFd write;
};

Result<Pipe> make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return system_error("make a pipe", errno);
  Pipe pipe{UniqueFd(ends[0]), UniqueFd(ends[1])};
  // The child's end blocks, as it expects; ours does not.
  if (::fcntl(pipe.read.get(), F_SETFL, O_NONBLOCK) != 0) return system_error("make a pipe", errno);
  return pipe;
}

/// glibc 2.36 declares pidfd_open without C linkage, so that C++ cannot link it.
int open_pidfd(pid_t pid) { return static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)); }

/// What posix_spawn is told, freed on every way out.
class SpawnPlan {
 public:
  SpawnPlan(int output, int messages) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawnattr_init(&attributes_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, output, STDERR_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, messages, kMessageDescriptor);
    posix_spawn_file_actions_addclosefrom_np(&actions_, kMessageDescriptor + 1);
    sigset_t all;
    sigset_t none;
    sigfillset(&all);
    sigemptyset(&none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  }
  ~SpawnPlan() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;

  int run(pid_t& pid, std::span<const std::string> command) const {
    std::vector<char*> arguments;
    for (const std::string& each : command) arguments.push_back(const_cast<char*>(each.c_str()));
    arguments.push_back(nullptr);
    std::string locale = "LC_ALL=C.UTF-8";
    std::array<char*, 2> environment{locale.data(), nullptr};
    return ::posix_spawn(&pid, arguments.front(), &actions_, &attributes_, arguments.data(), environment.data());
  }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

}  // namespace

Result<ChildProcess> ChildProcess::start(std::span<const std::string> command) {
  auto messages = make_pipe();
  if (!messages) return messages.error();
  auto output = make_pipe();
  if (!output) return output.error();
  ChildProcess child;
  const SpawnPlan plan(output->write.get(), messages->write.get());
  if (const int failed = plan.run(child.pid_, command); failed != 0) {
    child.pid_ = -1;
    return system_error("start a child process", failed);
  }
  child.pidfd_.reset(open_pidfd(child.pid_));
  if (!child.pidfd_) return system_error("watch a child process", errno);
  child.messages_ = std::move(messages->read);
  child.output_ = std::move(output->read);
  return child;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      pidfd_(std::move(other.pidfd_)),
      messages_(std::move(other.messages_)),
      output_(std::move(other.output_)) {}

ChildProcess::~ChildProcess() {
  if (pid_ > 0) reap();
}

std::uint64_t ChildProcess::memory_bytes() const {
  std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
  std::uint64_t kilobytes = 0;
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("RssAnon:") || line.starts_with("RssShmem:")) {
      kilobytes += std::strtoull(line.c_str() + line.find(':') + 1, nullptr, 10);
    }
  }
  return kilobytes * 1024;
}

void ChildProcess::signal_group(int signal) const { ::kill(-pid_, signal); }

ChildProcess::Exit ChildProcess::reap() {
  // The group is killed while its leader is not reaped yet: until then its id cannot be another's.
  signal_group(SIGKILL);
  int status = 0;
  rusage usage{};
  while (::wait4(pid_, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  Exit exit;
  if (WIFSIGNALED(status)) {
    exit.signal = WTERMSIG(status);
  } else {
    exit.code = WEXITSTATUS(status);
  }
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  exit.cpu_seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  exit.peak_memory_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  return exit;
}

}  // namespace surfaced
