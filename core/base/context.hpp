// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace surfaced {

/// Wall time of one stage of a run.
struct Stage {
  std::string name;
  double seconds = 0;
};

/// What a long computation is given by its caller: how many threads it may use, whether it shall
/// stop, and where it says how far it is. The stages it enters are timed without gaps.
///
/// Progress never falls. `enter` is called by the thread that owns the run; `report` and
/// `cancelled` by any thread.
class Context {
 public:
  /// Receives the fraction done (0..1, never falling) and the name of the stage.
  using Sink = std::function<void(double fraction, std::string_view stage)>;

  explicit Context(unsigned threads = 1, Sink sink = {}, const std::atomic<bool>* cancel = nullptr);

  /// Number of threads the work may use, at least 1.
  unsigned threads() const { return threads_; }

  /// True once the caller wants the work to stop; the work then returns ErrorCode::cancelled soon.
  bool cancelled() const { return cancel_ != nullptr && cancel_->load(std::memory_order_relaxed); }

  /// The stages entered from now on share the progress up to `until` (0..1) of the whole run.
  void section(double until);

  /// Ends the current stage and begins the named one, which takes the progress up to `until` (0..1) of
  /// the section. Entering a name again adds to its time.
  void enter(std::string_view stage, double until);

  /// Enters the stage, unless the caller wants to stop.
  Status begin(std::string_view stage, double until);

  /// Reports how much of the current stage is done (0..1).
  void report(double fraction_of_stage);

  /// Ends the current stage and returns the times of all stages in the order they were first entered.
  std::vector<Stage> finish();

 private:
  using Clock = std::chrono::steady_clock;
  void close_stage();
  void emit();

  unsigned threads_;
  Sink sink_;
  const std::atomic<bool>* cancel_;
  std::mutex mutex_;
  std::vector<Stage> stages_;
  std::size_t current_ = 0;
  bool open_ = false;
  Clock::time_point since_;
  double section_from_ = 0;
  double section_until_ = 1;
  double from_ = 0;
  double until_ = 0;
  double last_ = 0;
};

}  // namespace surfaced
