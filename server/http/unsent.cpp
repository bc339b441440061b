// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/unsent.hpp"

namespace surfaced::http {

void Unsent::note(std::uint64_t id, const Share& share, Clock::time_point time) {
  if (share.memory + share.kernel == 0) {
    forget(id);
    return;
  }
  const auto [found, fresh] = entries_.try_emplace(id, Entry{{}, time});
  Entry& entry = found->second;
  memory_ += share.memory - entry.share.memory;
  kernel_ += share.kernel - entry.share.kernel;
  if (fresh || share.taken != entry.share.taken) {
    by_time_.erase({entry.since, id});
    entry.since = time;
    by_time_.emplace(time, id);
  }
  entry.share = share;
}

void Unsent::forget(std::uint64_t id) {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return;
  memory_ -= found->second.share.memory;
  kernel_ -= found->second.share.kernel;
  by_time_.erase({found->second.since, id});
  entries_.erase(found);
}

std::optional<std::uint64_t> Unsent::overdue(Clock::time_point time) const {
  if (by_time_.empty()) return std::nullopt;
  const auto& [since, id] = *by_time_.begin();
  if (memory_ > limits_.memory || (is_short() && time - since >= limits_.patience)) return id;
  return std::nullopt;
}

}  // namespace surfaced::http
