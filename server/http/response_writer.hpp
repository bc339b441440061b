// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "http/message.hpp"

namespace surfaced::http {

/// RFC 9110's words for the status.
std::string_view reason_of(int status);

/// Status line, header fields in the order of their names, and the body where that is in memory and the method is not
/// HEAD; of streams the head alone.
/// @param close  the connection ends with this answer
std::string write_response(const Response& response, const Request& request, bool close);

}  // namespace surfaced::http
