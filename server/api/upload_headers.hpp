// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/base.hpp"
#include "http/message.hpp"

namespace surfaced::api {

/// Upload-Checksum of tus: an algorithm and the raw digest.
struct UploadChecksum {
  std::string algorithm;
  std::string digest;
};

/// A header that is a number of bytes; invalid_request if it is absent, given twice or no number.
Result<std::uint64_t> bytes_header(const http::Headers& headers, std::string_view name);

/// invalid_request for an algorithm that is not known or a digest that is no base64 of its length.
Result<std::optional<UploadChecksum>> checksum_header(const http::Headers& headers);

/// Upload-Metadata: pairs of a name and base64, checked; returned as it was given. invalid_request.
Result<std::string> metadata_header(const http::Headers& headers);

}  // namespace surfaced::api
