// SPDX-License-Identifier: GPL-3.0-or-later
// Cancelling in the middle of a computation, and how long it goes on then.
#pragma once

#include <atomic>
#include <string_view>

#include "support/patience.hpp"

namespace surfaced::testing {

/// Asks a computation to stop once it reports so much progress; its members are what a Context takes.
class CancelAt {
 public:
  explicit CancelAt(double when) : when_(when) {}

  auto sink() {
    return [this](double fraction, std::string_view) {
      if (fraction < when_ || cancel_) return;
      since_ = processor_seconds();
      cancel_ = true;
    };
  }
  const std::atomic<bool>* flag() const { return &cancel_; }
  /// Of the processor, since it was asked: what else the machine does does not count.
  double seconds() const { return processor_seconds() - since_; }

 private:
  double when_;
  std::atomic<bool> cancel_ = false;
  double since_ = 0;
};

}  // namespace surfaced::testing
