// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <span>
#include <string>

#include "base/base.hpp"
#include "base/unique_fd.hpp"

namespace surfaced {

/// A process of an attempt, leader of a process group of its own. When this object is destroyed the
/// group is killed and the process reaped, so that none stays behind.
class ChildProcess {
 public:
  /// Namespaces of users, processes and mounts for a process.
  enum class Namespaces : std::uint8_t { shared, its_own };

  /// How the process ended: its exit code, or the signal that ended it; and what it used.
  struct Exit {
    int code = 0;
    int signal = 0;
    /// It ended before its work began, because it cannot do without what its own namespaces keep from it.
    bool cannot_be_contained = false;
    bool paths_not_reached = false;
    double cpu_seconds = 0;
    /// As the kernel counts it; never less than what the server itself had when it started the process.
    std::uint64_t peak_memory_bytes = 0;
  };

  /// What the process is using, by /proc; nothing once it has ended.
  struct Use {
    /// Memory that is its own, not pages of files.
    std::uint64_t memory_bytes = 0;
    std::uint64_t threads = 0;
    /// What it has written to files and pipes; 0 if the kernel does not count it or does not tell.
    std::uint64_t written_bytes = 0;
  };

  /// Starts the command with an empty environment but for the locale, no input, and no descriptors but those below.
  /// The thread that calls this must outlive the child: the kernel ties the child's death to the thread, not the
  /// process.
  /// @param namespaces  `its_own` where the kernel permits it, else as `shared`; a process that has them does its work
  ///                    in a child of its own (see confine_this_process)
  static Result<ChildProcess> start(std::span<const std::string> command, Namespaces namespaces);

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

  Use use();

  /// Sends the signal to the whole group.
  void signal_group(int signal) const;

  /// Kills the whole group: the work first, so that what it has used is counted.
  void kill();

  /// Kills what is left of the group and reaps the process.
  Exit reap();

 private:
  ChildProcess() = default;
  /// The process that does the work: this one, or the only child of process 1 of a namespace once there is one.
  pid_t worker();
  /// Process 1 of a namespace cannot end itself by a signal, and tells by its code of one that has ended the work.
  static void judge_first_process(Exit& exit);

  pid_t pid_ = -1;
  pid_t worker_ = -1;
  UniqueFd worker_fd_;
  bool contained_ = false;
  UniqueFd pidfd_;
  UniqueFd messages_;
  UniqueFd output_;
};

}  // namespace surfaced
