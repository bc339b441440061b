// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: how algorithms of CGAL are stopped that offer no callback.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "base/cancelled.hpp"

namespace surfaced::baselines {

/// Thrown where an algorithm takes more steps than it may.
struct TooManySteps : std::runtime_error {
  explicit TooManySteps(std::uint64_t most)
      : std::runtime_error("it takes more than " + std::to_string(most) +
                           " steps, far more than so many points need: they are too unevenly spread; sample=grid and "
                           "outliers make them even, and other methods may take them") {}
};

/// While it lives, ticks on its thread look now and then at the caller's wish to stop, and whether there were too many:
/// the library's loops have no bound of their own. Steps are counted, not timed, so that every machine gives up on the
/// same clouds.
class Watch {
 public:
  /// @param most_ticks  the steps that may be taken: predicates of the kernel, rows of a linear system.
  Watch(const Context& context, std::uint64_t most_ticks)
      : context_(context), most_ticks_(most_ticks), outer_(current()) {
    current() = this;
  }
  ~Watch() { current() = outer_; }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  static void tick() {
    constexpr std::uint64_t kTicksBetweenChecks = 4096;
    Watch* const watch = current();
    if (watch != nullptr && ++watch->ticks_ % kTicksBetweenChecks == 0) check();
  }
  /// So many ticks, and a look at once.
  static void spend(std::uint64_t ticks) {
    if (current() == nullptr) return;
    current()->ticks_ += ticks;
    check();
  }

 private:
  static void check() {
    const Watch& watch = *current();
    stop_if_cancelled(watch.context_);
    if (watch.ticks_ > watch.most_ticks_) throw TooManySteps(watch.most_ticks_);
  }
  static Watch*& current() {
    thread_local Watch* watch = nullptr;
    return watch;
  }

  const Context& context_;
  std::uint64_t most_ticks_;
  Watch* outer_;
  std::uint64_t ticks_ = 0;
};

}  // namespace surfaced::baselines
