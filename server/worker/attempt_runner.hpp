// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "worker/attempt_log.hpp"
#include "worker/attempt_protocol.hpp"
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
  explicit AttemptRunner(std::vector<std::string> command) : command_(std::move(command)) {}

  /// Blocks until the child is gone: at most the limit of time and the grace.
  AttemptResult run(const AttemptSpec& spec, const StopSignal& stop, AttemptLog& log,
                    const ProgressSink& progress) const;

 private:
  std::vector<std::string> command_;
};

}  // namespace surfaced
