// SPDX-License-Identifier: GPL-3.0-or-later
#include "access/pace.hpp"

#include <algorithm>
#include <cmath>

namespace surfaced {

std::optional<std::chrono::seconds> Pace::take(std::string_view client, std::uint64_t per_minute,
                                               Clock::time_point time) {
  const std::scoped_lock lock(mutex_);
  const auto full = static_cast<double>(per_minute);
  const double rate = full / 60;
  if (buckets_.size() >= kMostClients) {
    std::erase_if(buckets_, [&](const auto& entry) { return time - entry.second.when > std::chrono::minutes(1); });
    // So many at once: better no limit for a moment than memory without one.
    if (buckets_.size() >= kMostClients) buckets_.clear();
  }
  const auto [found, fresh] = buckets_.try_emplace(std::string(client), Bucket{full, time});
  Bucket& bucket = found->second;
  const double passed = std::chrono::duration<double>(time - bucket.when).count();
  bucket.tokens = std::min(full, bucket.tokens + passed * rate);
  bucket.when = time;
  if (bucket.tokens >= 1) {
    bucket.tokens -= 1;
    return std::nullopt;
  }
  return std::chrono::seconds(static_cast<std::int64_t>(std::ceil((1 - bucket.tokens) / rate)));
}

}  // namespace surfaced
