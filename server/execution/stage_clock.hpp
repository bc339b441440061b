// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace surfaced {

/// Measures how long a child stays in each stage that it names, by the server's own clock.
class StageClock {
 public:
  /// The child is in this stage now.
  void enter(std::string_view stage) {
    if (stage == current_) return;
    close();
    current_ = stage;
  }

  /// The child has ended.
  void close() {
    const auto time = Clock::now();
    // A child may make up names without end.
    if (!current_.empty() && stages_.size() < kMost) {
      stages_.emplace_back(current_, std::chrono::duration<double>(time - since_).count());
    }
    since_ = time;
    current_.clear();
  }

  const std::vector<std::pair<std::string, double>>& stages() const { return stages_; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMost = 32;
  std::vector<std::pair<std::string, double>> stages_;
  std::string current_;
  Clock::time_point since_ = Clock::now();
};

}  // namespace surfaced
