#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "base/base.hpp"
#include "http/message.hpp"

namespace surfaced::http {

using Json = nlohmann::ordered_json;

/// Status that proto/errors.json gives the code.
int status_of(ErrorCode code);

/// The error as RFC 9457 asks for it, filled in from proto/errors.json.
/// @param instance  path of the request or the job; left out if empty
Json problem_json(const Error& error, std::string_view instance, std::string_view request_id);

/// The one function in which an error becomes HTTP.
Response problem_response(const Error& error, const Request& request);

/// JSON as bytes; what is no UTF-8 in it (a client's own words) is replaced.
std::string text_of(const Json& json);

Response json_response(int status, const Json& json);

}  // namespace surfaced::http
