// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

namespace surfaced {

/// Counts requests by client, a token bucket each: a minute's worth at once, then at the rate.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;

  /// Takes one request's worth; otherwise says how long to wait.
  std::optional<std::chrono::seconds> take(std::string_view client, std::uint64_t per_minute, Clock::time_point time);

 private:
  struct Bucket {
    double tokens = 0;
    Clock::time_point when;
  };
  // Clients are forgotten when their buckets are full again, and their number is bounded.
  static constexpr std::size_t kMostClients = 100'000;
  std::mutex mutex_;
  std::unordered_map<std::string, Bucket> buckets_;
};

}  // namespace surfaced
