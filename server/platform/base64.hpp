// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace surfaced {

/// Base64 with padding, RFC 4648 §4.
std::string base64_encode(std::string_view bytes);

/// The bytes, or none if the text is not what base64_encode writes.
std::optional<std::string> base64_decode(std::string_view text);

}  // namespace surfaced
