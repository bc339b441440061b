// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/request_context.hpp"

#include <algorithm>

namespace surfaced::api {
namespace {

constexpr std::size_t kLongestKey = 255;

/// The trace context, if it is one by the letter of the W3C: 00-TRACE-SPAN-FLAGS in lower-case hexadecimal.
std::string traceparent_of(const http::Request& request) {
  const std::string value(request.headers.find("traceparent").value_or(""));
  constexpr std::string_view kShape = "00-xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx-xxxxxxxxxxxxxxxx-xx";
  const bool fits = value.size() == kShape.size() && std::ranges::equal(value, kShape, [](char given, char shape) {
                      if (shape != 'x') return given == shape;
                      return (given >= '0' && given <= '9') || (given >= 'a' && given <= 'f');
                    });
  return fits ? value : std::string();
}

}  // namespace

Result<RequestContext> context_of(const http::Request& request) {
  RequestContext context{request.request_id, traceparent_of(request), request.caller};
  const auto key = request.headers.find("Idempotency-Key");
  if (!key) return context;
  std::string_view text = *key;
  // The draft asks for a quoted string; most clients send the bare text.
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  const bool clean = std::ranges::all_of(text, [](char c) { return c >= ' ' && c < '\x7f'; });
  if (text.empty() || text.size() > kLongestKey || !clean || request.headers.count("Idempotency-Key") > 1) {
    return with_fault(
        {ErrorCode::invalid_request, "Idempotency-Key has " + std::to_string(text.size()) +
                                         " characters; allowed are, once, 1 to 255 printable ones of ASCII"},
        {"Idempotency-Key", std::string(text.substr(0, kLongestKey)), "once, 1 to 255 printable characters of ASCII"});
  }
  context.idempotency_key = text;
  return context;
}

}  // namespace surfaced::api
