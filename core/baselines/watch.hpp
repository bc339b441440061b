// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: how algorithms of CGAL are stopped that offer no callback.
#pragma once

#include <cstdint>

#include "base/cancelled.hpp"

namespace surfaced::baselines {

/// While it lives, ticks on its thread look now and then at the caller's wish to stop.
class Watch {
 public:
  explicit Watch(const Context& context) : context_(context), outer_(current()) { current() = this; }
  ~Watch() { current() = outer_; }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  static void tick() {
    constexpr std::uint32_t kTicksBetweenChecks = 4096;
    Watch* const watch = current();
    if (watch != nullptr && ++watch->ticks_ % kTicksBetweenChecks == 0) check();
  }
  /// A tick that looks at once.
  static void check() {
    if (current() != nullptr) stop_if_cancelled(current()->context_);
  }

 private:
  static Watch*& current() {
    thread_local Watch* watch = nullptr;
    return watch;
  }

  const Context& context_;
  Watch* outer_;
  std::uint32_t ticks_ = 0;
};

}  // namespace surfaced::baselines
