// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "base/base.hpp"

namespace surfaced {

/// True for an address that the internet routes to somebody: not private, loopback, link-local, shared, documentation,
/// multicast, reserved, or one of those inside IPv6 (mapped, translated, 6to4, Teredo).
bool is_public_address(std::string_view address);

/// The target of a webhook, found out before a connection is made.
struct WebhookTarget {
  std::string host;
  std::string port;
  /// The one address that the connection is pinned to, so that a name cannot change its mind after the check.
  std::string address;
};

/// Takes an https URL apart and looks its host up; every address of it has to be public.
/// @param private_too  for networks of one's own
/// @return invalid_parameter with the reason
Result<WebhookTarget> resolve_target(const std::string& url, bool private_too);

}  // namespace surfaced
