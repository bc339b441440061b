// SPDX-License-Identifier: GPL-3.0-or-later
// The viewer as bytes inside the binary.
#pragma once

#include <span>
#include <string_view>

namespace surfaced::web {

/// A file that the daemon serves.
struct Asset {
  /// Below the root: `index.html`, `assets/…`, `samples/…`.
  std::string_view path;
  std::string_view content_type;
  /// Strong, with its quotes; that of the compressed form is `etag_gzip`.
  std::string_view etag;
  std::string_view etag_gzip;
  std::string_view bytes;
  /// Empty where compressing gains nothing.
  std::string_view gzip;
  /// Its name is made of its content, so that it never changes.
  bool immutable = false;
};

/// By path, ascending; none in a build without the viewer.
std::span<const Asset> assets();

}  // namespace surfaced::web
