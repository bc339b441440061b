// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "worker/attempt_log.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/child_process.hpp"
#include "worker/stop_signal.hpp"

namespace surfaced {

/// How an attempt ended, and why unless it is done.
struct AttemptResult {
  Outcome outcome = Outcome::lost;
  std::optional<Error> error;
  Usage usage{};
};

/// Runs attempts, each in a child process that is started for it and gone when `run` returns.
///
///   start --> working --ends by itself-----------------------> reaped
///                |                                               ^
///                |--stopped or out of time--> TERM --ends--------|
///                |                              '--grace over----|
///                '--over its memory----------------------------> KILL of the group
class AttemptRunner {
 public:
  using ProgressSink = std::function<void(double progress, std::string_view phase)>;

  /// @param command  program and arguments that the attempt's description is appended to
  /// @param namespaces  what attempts are started in; where that does not do they share the server's from then on
  explicit AttemptRunner(std::vector<std::string> command,
                         ChildProcess::Namespaces namespaces = ChildProcess::Namespaces::its_own)
      : command_(std::move(command)), namespaces_(namespaces) {}

  /// Blocks until the child is gone: at most the limit of time and the grace.
  AttemptResult run(const AttemptSpec& spec, const StopSignal& stop, AttemptLog& log,
                    const ProgressSink& progress) const;

 private:
  struct Run {
    AttemptResult result;
    bool cannot_be_contained = false;
    bool paths_not_reached = false;
  };
  Result<Run> run_once(const std::vector<std::string>& command, ChildProcess::Namespaces namespaces,
                       const AttemptSpec& spec, const StopSignal& stop, AttemptLog& log,
                       const ProgressSink& progress) const;

  const std::vector<std::string> command_;
  mutable std::atomic<ChildProcess::Namespaces> namespaces_;
};

}  // namespace surfaced
