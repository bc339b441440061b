#pragma once

#include <string>
#include <vector>

#include "http/message.hpp"

namespace surfaced::http {

/// A body that is in memory.
BodyStream body_of(std::string text);

/// The body as base64, encoded while it is sent.
BodyStream base64_of(BodyStream body);

/// The bodies one behind the other.
BodyStream joined(std::vector<BodyStream> parts);

}  // namespace surfaced::http
