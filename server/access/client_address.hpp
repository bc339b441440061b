// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "http/message.hpp"
#include "platform/network.hpp"

namespace surfaced {

/// The address of the client: that of the connection, or, behind a trusted proxy, what X-Forwarded-For says. All fields
/// of that name are one list (RFC 9110 §5.3), read from the right, where the nearest proxy wrote, to the first address
/// that is not trusted: what stands to the left of it is the client's own word.
/// @param connection  address of the connection
/// @return  "unknown" if a trusted proxy names something that is no address
std::string client_address(const std::string& connection, const http::Headers& headers,
                           const std::vector<Network>& trusted);

}  // namespace surfaced
