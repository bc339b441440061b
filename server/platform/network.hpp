// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"

namespace surfaced {

/// An address of either family as 128 bits; IPv4 is mapped into IPv6 (::ffff:a.b.c.d), so that both spellings are one.
using AddressBytes = std::array<std::uint8_t, 16>;

/// The address that the text spells; none for anything else, names and zones among it.
std::optional<AddressBytes> address_in(std::string_view text);

bool is_ip_address(std::string_view text);

/// True for 127.0.0.0/8, ::1 and localhost.
bool is_loopback(std::string_view host);

/// Those who count as one client: the /64 of an IPv6 address, for that is what one customer is given, "a:b:c:d::/64";
/// IPv4 addresses by their one spelling. What is no address, the id of a key say, stays as it is.
std::string client_group(std::string_view client);

/// An address, or a network: 10.0.0.0/8, 2001:db8::/32.
class Network {
 public:
  static std::optional<Network> parse(std::string_view text);
  bool holds(const AddressBytes& address) const;

 private:
  AddressBytes address_{};
  unsigned bits_ = 128;
};

/// Those that commas separate; invalid_usage with the entry that is none.
Result<std::vector<Network>> networks_in(std::string_view list);

}  // namespace surfaced
