// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "http/message.hpp"

namespace surfaced::http {

/// A body that is in memory.
BodyStream body_of(std::string text);

/// A body of the program's own data, which is not copied.
BodyStream body_of_static(std::string_view bytes);

/// The body as base64, encoded while it is sent.
BodyStream base64_of(BodyStream body);

/// The bodies one behind the other.
BodyStream concatenated(std::vector<BodyStream> parts);

}  // namespace surfaced::http
