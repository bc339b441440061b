#include "http/body_places.hpp"

namespace surfaced::http {

Result<BodyPlaces::Place> BodyPlaces::take(const std::string& address) {
  const std::scoped_lock lock(mutex_);
  if (taken_ >= total_) {
    return Error{ErrorCode::not_ready,
                 std::to_string(taken_) + " bodies are being received, the limit is " + std::to_string(total_)};
  }
  const bool loopback = address == "::1" || address.starts_with("127.") || address.starts_with("::ffff:127.");
  const auto found = by_address_.find(address);
  if (per_address_ > 0 && !loopback && found != by_address_.end() && found->second >= per_address_) {
    return Error{ErrorCode::too_many_requests, std::to_string(found->second) + " bodies are being received from " +
                                                   address + ", the limit is " + std::to_string(per_address_)};
  }
  ++by_address_[address];
  ++taken_;
  return Place(this, address);
}

void BodyPlaces::leave(const std::string& address) {
  const std::scoped_lock lock(mutex_);
  --taken_;
  const auto found = by_address_.find(address);
  if (--found->second == 0) by_address_.erase(found);
}

}  // namespace surfaced::http
