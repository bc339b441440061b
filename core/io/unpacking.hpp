// SPDX-License-Identifier: GPL-3.0-or-later
// What files are wrapped in: gzip, ZIP archives, UTF-16.
#pragma once

#include <string>
#include <string_view>

#include "io/formats.hpp"

namespace surfaced::io {

/// A file out of its wrapping, and the files beside it.
struct Unwrapped {
  /// As it is called in the archive; empty outside of one.
  std::string name;
  Bytes bytes;
};

bool looks_like_gzip(std::span<const std::byte> bytes);

/// Everything that gzip holds. It may take 32 MiB and 40 times the packed bytes.
/// @return  unsupported_feature beyond that; malformed_input, truncated_input.
Result<Bytes> gunzipped(std::span<const std::byte> bytes, std::string_view name);

/// The one cloud of an archive, told by the extensions of its files.
/// @return  unsupported_feature if there is none, or more than one; errors of unpacking. The limits are those of gzip.
Result<Unwrapped> cloud_in_zip(std::span<const std::byte> bytes, std::string_view name);

/// Files of the archive beside one of them. Together they may take what the archive may.
/// @pre  bytes outlive the result.
Beside beside_in_zip(std::span<const std::byte> bytes, std::string_view name, const std::string& member);

/// Files in a folder and below it.
Beside beside_in_folder(const std::filesystem::path& folder);

/// Whether text begins with the byte order mark of UTF-16, or every other byte of its beginning is 0.
bool looks_like_utf16(std::span<const std::byte> bytes);

/// The same text in UTF-8; what is no character becomes '?'.
Bytes utf8_of_utf16(std::span<const std::byte> bytes);

}  // namespace surfaced::io
