// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/permits.hpp"

#include "platform/network.hpp"

namespace surfaced::http {

Result<Permits::Permit> Permits::acquire(const std::string& asking) {
  const std::string client = client_group(asking);
  const std::scoped_lock lock(mutex_);
  if (held_ >= total_) {
    return Error{ErrorCode::not_ready,
                 std::to_string(held_) + " " + what_ + ", the limit is " + std::to_string(total_)};
  }
  const auto found = by_client_.find(client);
  if (per_client_ > 0 && !is_loopback(client) && found != by_client_.end() && found->second >= per_client_) {
    return Error{ErrorCode::too_many_requests, std::to_string(found->second) + " " + what_ + " for " + client +
                                                   ", the limit is " + std::to_string(per_client_)};
  }
  ++by_client_[client];
  ++held_;
  return Permit(this, client);
}

void Permits::release(const std::string& client) {
  const std::scoped_lock lock(mutex_);
  --held_;
  const auto found = by_client_.find(client);
  if (--found->second == 0) by_client_.erase(found);
}

}  // namespace surfaced::http
