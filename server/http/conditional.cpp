// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/conditional.hpp"

#include <charconv>
#include <string>

#include "http/problem.hpp"
#include "platform/base64.hpp"
#include "platform/lists.hpp"

namespace surfaced::http {
namespace {

/// Reads digits to the end of the text.
std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failed != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// "first-last", "first-" or "-count" of a Range header; none if it is something else.
struct RangeSpec {
  std::optional<std::uint64_t> first;
  std::optional<std::uint64_t> last;
};
std::optional<RangeSpec> parse_range(std::string_view value) {
  const std::size_t dash = value.find('-');
  if (dash == value.npos) return std::nullopt;
  const std::string_view before = value.substr(0, dash);
  const std::string_view after = value.substr(dash + 1);
  const RangeSpec spec{number_in(before), number_in(after)};
  const bool readable = (before.empty() || spec.first) && (after.empty() || spec.last) && (spec.first || spec.last);
  if (!readable || (spec.first && spec.last && *spec.first > *spec.last)) return std::nullopt;
  return spec;
}

constexpr std::string_view kUnit = "bytes=";

Error not_satisfiable(std::string_view value, std::uint64_t size) {
  return wrong_value(ErrorCode::range_not_satisfiable, "Range", value,
                     "bytes=FIRST-LAST, bytes=FIRST- or bytes=-COUNT within " + std::to_string(size) + " bytes");
}

/// True if every part of the list is a range.
bool is_list_of_ranges(std::string_view list) {
  for (;;) {
    const bool last = list.find(',') == list.npos;
    if (!parse_range(take_entry(list))) return false;
    if (last) return true;
  }
}

}  // namespace

bool not_modified(const Headers& headers, std::string_view etag) {
  const auto given = headers.find("If-None-Match");
  if (!given) return false;
  std::string_view list = *given;
  while (!list.empty()) {
    std::string_view tag = take_entry(list);
    // A weak tag matches too: If-None-Match compares weakly.
    if (tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag == "*" || tag == etag) return true;
  }
  return false;
}

Result<std::optional<ByteRange>> requested_range(const Headers& headers, std::string_view etag, std::uint64_t size) {
  const auto value = headers.find("Range");
  if (!value || headers.count("Range") > 1) return std::optional<ByteRange>();
  if (const auto condition = headers.find("If-Range"); condition && *condition != etag)
    return std::optional<ByteRange>();
  // A unit that is not known here is to be ignored (RFC 9110 §14.2); so may several parts be.
  if (value->size() < kUnit.size() || !same_name(value->substr(0, kUnit.size()), kUnit))
    return std::optional<ByteRange>();
  const std::string_view list = value->substr(kUnit.size());
  if (list.find(',') != list.npos && is_list_of_ranges(list)) return std::optional<ByteRange>();
  const auto spec = parse_range(list);
  if (!spec) return not_satisfiable(*value, size);
  const std::uint64_t first = spec->first ? *spec->first : size - std::min(size, *spec->last);
  if (first >= size || (!spec->first && *spec->last == 0)) return not_satisfiable(*value, size);
  const std::uint64_t end = spec->first && spec->last && *spec->last < size ? *spec->last + 1 : size;
  return std::optional(ByteRange{first, end - first});
}

std::string digest_field(std::string_view sha256_hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < sha256_hex.size(); i += 2) {
    unsigned byte = 0;
    std::from_chars(sha256_hex.data() + i, sha256_hex.data() + i + 2, byte, 16);
    bytes += static_cast<char>(byte);
  }
  return "sha-256=:" + base64_encode(bytes) + ":";
}

Response conditional_response(const Request& request, std::string_view etag, std::string content_type,
                              BodyStream body) {
  const std::uint64_t size = body.length;
  // Only GET has ranges (RFC 9110 §14.2).
  const auto range = request.method == "GET" ? requested_range(request.headers, etag, size)
                                             : Result<std::optional<ByteRange>>(std::optional<ByteRange>());
  Response response;
  response.content_type = std::move(content_type);
  if (not_modified(request.headers, etag)) {
    response.status = 304;
    response.content_type.clear();
  } else if (!range) {
    response = problem_response(range.error(), request);
    response.headers.add("Content-Range", "bytes */" + std::to_string(size));
    return response;
  } else if (range->has_value()) {
    const ByteRange part = **range;
    response.status = 206;
    response.headers.add("Content-Range", "bytes " + std::to_string(part.offset) + "-" +
                                              std::to_string(part.offset + part.length - 1) + "/" +
                                              std::to_string(size));
    response.body =
        BodyStream{part.length, [read = std::move(body.read), part](std::uint64_t offset, std::span<std::byte> buffer) {
                     const auto count = std::min<std::uint64_t>(buffer.size(), part.length - offset);
                     return read(part.offset + offset, buffer.first(count));
                   }};
  } else {
    response.body = std::move(body);
  }
  response.headers.add("ETag", std::string(etag));
  response.headers.add("Accept-Ranges", "bytes");
  response.headers.add("Cache-Control", "private, no-cache");
  return response;
}

}  // namespace surfaced::http
