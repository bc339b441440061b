// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "base/base.hpp"
#include "http/message.hpp"

namespace surfaced::http {

using Json = nlohmann::ordered_json;

/// An error about one named thing, which is also its fault: "'limit' is 'x'; allowed is a number from 1 to 200".
Error wrong_value(ErrorCode code, std::string_view field, std::string_view value, std::string_view allowed);

/// "'cloud_id' is missing; needed is ..."
Error missing_value(ErrorCode code, std::string_view field, std::string_view needed);

/// Status that proto/errors.json gives the code.
int status_of(ErrorCode code);

/// The error as RFC 9457 asks for it, filled in from proto/errors.json.
/// @param instance  path of the request or the job; left out if empty
Json problem_json(const Error& error, std::string_view instance, std::string_view request_id);

/// The one function in which an error becomes HTTP.
Response problem_response(const Error& error, const Request& request);

/// The same as bytes, for a connection that ends before it has a request.
std::string closing_answer(const Error& error, std::string_view request_id);

/// JSON as bytes; what is no UTF-8 in it (a client's own words) is replaced.
std::string text_of(const Json& json);

Response json_response(int status, const Json& json);

}  // namespace surfaced::http
