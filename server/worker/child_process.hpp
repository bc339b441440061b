// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <span>
#include <string>

#include "base/base.hpp"
#include "platform/unique_fd.hpp"

namespace surfaced {

/// A process of an attempt, leader of a process group of its own. When this object is destroyed the
/// group is killed and the process reaped, so that none stays behind.
class ChildProcess {
 public:
  /// How the process ended: its exit code, or the signal that ended it; and what it used.
  struct Exit {
    int code = 0;
    int signal = 0;
    double cpu_seconds = 0;
    /// As the kernel counts it; never less than what the server itself had when it started the process.
    std::uint64_t peak_memory_bytes = 0;
  };

  /// Starts the command (posix_spawn, which is safe in a process of many threads) with an empty
  /// environment but for the locale, no input, and no descriptors but those below. The thread that
  /// calls this must outlive the child: the kernel ties the child's death to the thread, not the process.
  static Result<ChildProcess> start(std::span<const std::string> command);

  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess();

  /// Readable once the process has ended.
  int ended_descriptor() const { return pidfd_.get(); }
  /// What it writes to descriptor 3; not blocking.
  int messages() const { return messages_.get(); }
  /// What it writes to standard output and standard error; not blocking.
  int output() const { return output_.get(); }

  /// Memory that is the process's own (not pages of files), by /proc; 0 once it has ended.
  std::uint64_t memory_bytes() const;

  /// Sends the signal to the whole group.
  void signal_group(int signal) const;

  /// Kills what is left of the group and reaps the process.
  Exit reap();

 private:
  ChildProcess() = default;
  pid_t pid_ = -1;
  UniqueFd pidfd_;
  UniqueFd messages_;
  UniqueFd output_;
};

}  // namespace surfaced
