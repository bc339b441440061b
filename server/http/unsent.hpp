// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace surfaced::http {

/// Counts what clients have not taken of their answers, in this process and in the buffers of the kernel, and says who
/// has to go when that is too much: the one who has taken nothing for the longest. Not safe in threads.
class Unsent {
 public:
  using Clock = std::chrono::steady_clock;
  struct Limits {
    /// Bytes in all, beyond which whoever has taken nothing for `patience` is ended.
    std::uint64_t total = std::uint64_t{32} << 20;
    /// Bytes in this process, beyond which somebody is ended at once.
    std::uint64_t memory = std::uint64_t{96} << 20;
    std::chrono::milliseconds patience{1'000};
  };
  explicit Unsent(const Limits& limits) : limits_(limits) {}

  struct Share {
    std::uint64_t memory = 0;
    std::uint64_t kernel = 0;
    /// That the client has taken since the connection began; with it his patience begins anew.
    std::uint64_t taken = 0;
  };
  /// What a connection holds now; nothing is the same as `forget`.
  void note(std::uint64_t id, const Share& share, Clock::time_point time);
  void forget(std::uint64_t id);

  /// The connection that is to be looked at, and ended if it still has taken nothing.
  std::optional<std::uint64_t> overdue(Clock::time_point time) const;
  /// There is too much: look again before long.
  bool is_short() const { return memory_ + kernel_ > limits_.total; }
  std::uint64_t bytes() const { return memory_ + kernel_; }

 private:
  struct Entry {
    Share share;
    Clock::time_point since;
  };
  const Limits limits_;
  std::map<std::uint64_t, Entry> entries_;
  std::set<std::pair<Clock::time_point, std::uint64_t>> by_time_;
  std::uint64_t memory_ = 0;
  std::uint64_t kernel_ = 0;
};

}  // namespace surfaced::http
