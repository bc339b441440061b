// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

namespace surfaced {

/// The receivers that something is being sent to: one delivery at a time for each host and port, so that a slow one
/// keeps back its own and nobody else's; and a share of the deliveries for each address, so that nobody takes them all
/// by having many names. Safe in threads.
class Receivers {
 public:
  struct Limits {
    std::size_t at_once = 24;
    std::size_t per_address = 8;
  };
  explicit Receivers(const Limits& limits) : limits_(limits) {}

  /// How many more may be taken.
  std::size_t room() const;
  /// True if nothing is on its way to the receiver, and the address that it had last has room.
  bool is_free(const std::string& name) const;
  /// From now until `leave` something is on its way to it.
  void take(const std::string& name);
  /// Its name led to this address; false if the address has no room, which is_free then knows.
  bool settle(const std::string& name, std::string_view address);
  void leave(const std::string& name);

 private:
  bool has_room(const std::string& group) const;

  const Limits limits_;
  mutable std::mutex mutex_;
  /// By name, the address (client_group of platform/network.hpp) once it is known.
  std::map<std::string, std::string> busy_;
  std::map<std::string, std::size_t> by_address_;
  /// Where names led before; bounded.
  std::map<std::string, std::string> known_;
};

}  // namespace surfaced
