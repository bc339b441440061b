// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/upload_headers.hpp"

#include <algorithm>
#include <charconv>

#include "http/problem.hpp"
#include "platform/base64.hpp"
#include "platform/digest.hpp"
#include "platform/lists.hpp"

namespace surfaced::api {
namespace {

constexpr std::size_t kMaxMetadata = 4096;

}  // namespace

Result<std::uint64_t> bytes_header(const http::Headers& headers, std::string_view name) {
  const auto text = headers.find(name);
  if (!text) return http::missing_value(ErrorCode::invalid_request, name, "the header with a number of bytes");
  std::uint64_t number = 0;
  const auto [end, failed] = std::from_chars(text->data(), text->data() + text->size(), number);
  if (failed == std::errc() && end == text->data() + text->size() && headers.count(name) == 1) return number;
  return http::wrong_value(ErrorCode::invalid_request, name, *text, "once, a number of bytes");
}

Result<std::optional<UploadChecksum>> checksum_header(const http::Headers& headers) {
  const auto text = headers.find("Upload-Checksum");
  if (!text) return std::optional<UploadChecksum>();
  const std::size_t blank = text->find(' ');
  const std::string algorithm(text->substr(0, blank));
  auto digest = Digest::named(algorithm);
  const auto bytes = blank == text->npos ? std::nullopt : base64_decode(text->substr(blank + 1));
  if (digest && bytes && bytes->size() == digest->finish().size())
    return std::optional(UploadChecksum{algorithm, *bytes});
  return http::wrong_value(ErrorCode::invalid_request, "Upload-Checksum", *text,
                           "sha1, sha256, sha512 or md5, a blank, and the digest in base64");
}

Result<std::string> metadata_header(const http::Headers& headers) {
  const std::string_view whole = headers.find("Upload-Metadata").value_or("");
  const auto refuse = [&](const char* allowed) {
    return http::wrong_value(ErrorCode::invalid_request, "Upload-Metadata", whole, allowed);
  };
  if (whole.size() > kMaxMetadata) return refuse("up to 4096 bytes");
  for (std::string_view left = whole; !left.empty();) {
    const std::string_view pair = take_entry(left);
    const std::size_t blank = pair.find(' ');
    const std::string_view name = pair.substr(0, blank);
    const bool clean = std::ranges::all_of(name, [](char c) { return c > ' ' && c < '\x7f'; });
    if (name.empty() || !clean) return refuse("pairs whose names are printable ASCII");
    if (blank != pair.npos && blank + 1 < pair.size() && !base64_decode(pair.substr(blank + 1))) {
      return refuse("pairs whose values are base64");
    }
  }
  return std::string(whole);
}

}  // namespace surfaced::api
