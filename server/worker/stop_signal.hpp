// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/eventfd.h>

#include <atomic>
#include <cstdint>
#include <optional>

#include "base/unique_fd.hpp"
#include "jobs/job.hpp"

namespace surfaced {

/// Tells a running attempt to stop, and why: `cancelled` or `drained`. The first reason counts.
class StopSignal {
 public:
  StopSignal() : event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

  void stop(Outcome why) {
    std::uint8_t none = kNone;
    if (!why_.compare_exchange_strong(none, static_cast<std::uint8_t>(why))) return;
    // An eventfd takes a write of 1 unless its counter is full, and this is the only one.
    [[maybe_unused]] const int failed = ::eventfd_write(event_.get(), 1);
  }

  std::optional<Outcome> why() const {
    const std::uint8_t why = why_.load();
    return why == kNone ? std::nullopt : std::optional(static_cast<Outcome>(why));
  }

  /// Readable once the attempt shall stop.
  int descriptor() const { return event_.get(); }

 private:
  static constexpr std::uint8_t kNone = 0xFF;
  UniqueFd event_;
  std::atomic<std::uint8_t> why_{kNone};
};

}  // namespace surfaced
