// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/base.hpp"
#include "http/message.hpp"

namespace surfaced::http {

/// A run of bytes of a representation.
struct ByteRange {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
};

/// True if the request's If-None-Match names this ETag (or is `*`): the answer is then 304.
bool not_modified(const Headers& headers, std::string_view etag);

/// The one range that the request asks for; none if it asks for the whole: without Range, with an
/// If-Range that does not match, with a Range of another unit or of several parts (RFC 9110 lets a
/// server ignore those). range_not_satisfiable if the range begins behind the end, or is none.
Result<std::optional<ByteRange>> requested_range(const Headers& headers, std::string_view etag, std::uint64_t size);

/// Value of Repr-Digest (RFC 9530) for a SHA-256 in hexadecimal digits.
std::string digest_field(std::string_view sha256_hex);

/// Answers GET or HEAD of a representation with a strong ETag: 200, 206, 304, or 416.
Response conditional_response(const Request& request, std::string_view etag, std::string content_type, BodyStream body);

}  // namespace surfaced::http
