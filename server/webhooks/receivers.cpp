// SPDX-License-Identifier: GPL-3.0-or-later
#include "webhooks/receivers.hpp"

#include <algorithm>

#include "platform/network.hpp"

namespace surfaced {
namespace {

constexpr std::size_t kMostKnown = 10'000;

}  // namespace

std::size_t Receivers::room() const {
  const std::scoped_lock lock(mutex_);
  return limits_.at_once - std::min(limits_.at_once, busy_.size());
}

bool Receivers::has_room(const std::string& group) const {
  const auto found = by_address_.find(group);
  return found == by_address_.end() || found->second < limits_.per_address;
}

bool Receivers::is_free(const std::string& name) const {
  const std::scoped_lock lock(mutex_);
  const auto known = known_.find(name);
  return !busy_.contains(name) && (known == known_.end() || has_room(known->second));
}

void Receivers::take(const std::string& name) {
  const std::scoped_lock lock(mutex_);
  busy_.emplace(name, "");
}

bool Receivers::settle(const std::string& name, std::string_view address) {
  const std::string group = client_group(address);
  const std::scoped_lock lock(mutex_);
  if (known_.size() >= kMostKnown) known_.clear();
  known_[name] = group;
  if (!has_room(group)) return false;
  busy_.at(name) = group;
  ++by_address_[group];
  return true;
}

void Receivers::leave(const std::string& name) {
  const std::scoped_lock lock(mutex_);
  const auto found = busy_.find(name);
  if (found == busy_.end()) return;
  if (const auto address = by_address_.find(found->second); address != by_address_.end() && --address->second == 0) {
    by_address_.erase(address);
  }
  busy_.erase(found);
}

}  // namespace surfaced
