// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "base/base.hpp"
#include "http/message.hpp"

namespace surfaced::http {

/// How the end of a body is known.
struct NoBody {};
struct LengthBody {
  std::uint64_t bytes = 0;
};
struct ChunkedBody {};
using Framing = std::variant<NoBody, LengthBody, ChunkedBody>;

/// Request line and header fields.
struct RequestHead {
  std::string method;
  /// Path and query as they were sent; a target in absolute form has had its host put into the Host header.
  std::string path;
  std::string query;
  Headers headers;
  Framing framing;
  /// The client speaks HTTP/1.0 or asks for the connection to be closed.
  bool close = false;
  /// The client waits for "100 Continue" before it sends the body.
  bool expects_continue = false;
};

/// Reads a head that ends with an empty line, by the letter of RFC 9112: what two readers could
/// understand differently is refused (Content-Length with Transfer-Encoding, two lengths, folded lines,
/// a line feed alone), so that nothing can be smuggled past a proxy.
/// @return  invalid_request, headers_too_large for more than 100 fields.
Result<RequestHead> parse_head(std::string_view text);

/// Decodes %XX; with `plus_is_space`, as in a query, + too. invalid_request for a broken escape, a NUL,
/// or bytes that are no UTF-8.
Result<std::string> percent_decode(std::string_view text, bool plus_is_space);

/// %XX for everything but letters, digits and -._~.
std::string percent_encode(std::string_view text);

/// As Unicode defines it: no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(std::string_view text);

/// True for what a Host header may say: a name of letters, digits, -, . and _, or an address (IPv6 in brackets), and
/// perhaps a port.
bool is_host(std::string_view text);

/// Decodes a=b&c=d. invalid_request for more than 200 names.
Result<Query> parse_query(std::string_view text);

}  // namespace surfaced::http
