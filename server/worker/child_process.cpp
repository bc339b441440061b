// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <sstream>
#include <utility>
#include <vector>

#include "platform/files.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/contained_start.hpp"
#include "worker/sanitizers.hpp"

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

  int run(pid_t& pid, char* const* command, char* const* environment) const {
    return ::posix_spawn(&pid, command[0], &actions_, &attributes_, command, environment);
  }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

/// The sum of the numbers in the lines that begin with one of these.
std::uint64_t sum_of(std::istream& lines, std::initializer_list<std::string_view> beginnings) {
  std::uint64_t sum = 0;
  for (std::string line; std::getline(lines, line);) {
    for (const std::string_view beginning : beginnings) {
      if (line.starts_with(beginning)) sum += std::strtoull(line.c_str() + beginning.size(), nullptr, 10);
    }
  }
  return sum;
}

std::string proc_file(pid_t pid, std::string_view name) {
  return "/proc/" + std::to_string(pid) + "/" + std::string(name);
}

/// A child of this process, -1 if it has none. Not every kernel lists them; then all processes are asked for their
/// parents.
pid_t child_of(pid_t parent) {
  pid_t found = -1;
  if (std::ifstream list(proc_file(parent, "task/" + std::to_string(parent) + "/children")); list) {
    return list >> found ? found : -1;
  }
  const auto processes = entries_of("/proc");
  if (!processes) return -1;
  for (const std::filesystem::path& each : *processes) {
    const auto pid = static_cast<pid_t>(std::strtol(each.filename().c_str(), nullptr, 10));
    if (pid <= 0) continue;
    std::ifstream status(proc_file(pid, "status"));
    if (sum_of(status, {"PPid:"}) == static_cast<std::uint64_t>(parent)) return pid;
  }
  return -1;
}

}  // namespace

Result<ChildProcess> ChildProcess::start(std::span<const std::string> command, Namespaces namespaces) {
  auto messages = make_pipe();
  if (!messages) return messages.error();
  auto output = make_pipe();
  if (!output) return output.error();
  std::vector<char*> arguments;
  for (const std::string& each : command) arguments.push_back(const_cast<char*>(each.c_str()));
  arguments.push_back(nullptr);
  std::string locale = "LC_ALL=C.UTF-8";
  std::array<char*, 2> environment{locale.data(), nullptr};
  ChildProcess child;
  if (namespaces == Namespaces::its_own && !kSanitized) {
    child.pid_ = start_contained(arguments.data(), environment.data(), output->write.get(), messages->write.get());
    child.contained_ = child.pid_ > 0;
  }
  if (!child.contained_) {
    const SpawnPlan plan(output->write.get(), messages->write.get());
    if (const int failed = plan.run(child.pid_, arguments.data(), environment.data()); failed != 0) {
      child.pid_ = -1;
      return system_error("start a child process", failed);
    }
  }
  child.pidfd_.reset(open_pidfd(child.pid_));
  if (!child.pidfd_) return system_error("watch a child process", errno);
  child.messages_ = std::move(messages->read);
  child.output_ = std::move(output->read);
  return child;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      worker_(other.worker_),
      worker_fd_(std::move(other.worker_fd_)),
      contained_(other.contained_),
      pidfd_(std::move(other.pidfd_)),
      messages_(std::move(other.messages_)),
      output_(std::move(other.output_)) {}

ChildProcess::~ChildProcess() {
  if (pid_ > 0) reap();
}

pid_t ChildProcess::worker() {
  if (!contained_) return pid_;
  if (worker_ >= 0) return worker_;
  const pid_t found = child_of(pid_);
  if (found < 0) return -1;
  UniqueFd handle(open_pidfd(found));
  // Once it is certain that the handle is not on a later process of the same number.
  if (!handle || child_of(pid_) != found) return -1;
  worker_fd_ = std::move(handle);
  worker_ = found;
  return worker_;
}

void ChildProcess::kill() {
  constexpr int kMilliseconds = 500;
  if (contained_ && worker() >= 0) {
    ::syscall(SYS_pidfd_send_signal, worker_fd_.get(), SIGKILL, nullptr, 0);
    // The first process counts what it has waited for, and nothing if it is killed itself.
    pollfd ended{pidfd_.get(), POLLIN, 0};
    ::poll(&ended, 1, kMilliseconds);
  }
  signal_group(SIGKILL);
}

ChildProcess::Use ChildProcess::use() {
  const pid_t pid = worker();
  if (pid < 0) return {};
  std::ifstream status_file(proc_file(pid, "status"));
  std::stringstream status;
  status << status_file.rdbuf();
  const std::uint64_t kilobytes = sum_of(status, {"RssAnon:", "RssShmem:"});
  status.clear();
  status.seekg(0);
  std::ifstream counts(proc_file(pid, "io"));
  return {kilobytes * 1024, sum_of(status, {"Threads:"}), sum_of(counts, {"wchar:"})};
}

void ChildProcess::judge_first_process(Exit& exit) {
  exit.cannot_be_contained = exit.signal == SIGSYS || (exit.signal == 0 && exit.code == kCannotBeContained);
  exit.paths_not_reached = exit.signal == 0 && exit.code == kPathsNotReached;
  if (exit.signal != 0 || exit.code < kEndedBySignal) return;
  exit.signal = exit.code - kEndedBySignal;
  exit.code = 0;
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
  if (contained_) judge_first_process(exit);
  exit.cpu_seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  exit.peak_memory_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  return exit;
}

}  // namespace surfaced
