// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "base/base.hpp"

namespace surfaced::http {

/// Head of a part of multipart/form-data.
struct Part {
  std::string name;
  /// A part with a file name is a file, whatever its size.
  bool is_file = false;
};

/// What becomes of the parts, in their order. The first error ends the reading.
struct PartSink {
  std::function<Status(const Part&)> begin;
  std::function<Status(std::span<const std::byte>)> data;
  std::function<Status()> end;
};

/// Boundary of a Content-Type of multipart/form-data; invalid_request if it has none that RFC 2046 allows.
Result<std::string> multipart_boundary(std::string_view content_type);

/// Reads multipart/form-data (RFC 7578) piece by piece and holds no more of it than the head of a part. Written by
/// hand: cpp-httplib reads it only into memory, or with a parser of its own that bounds neither heads nor parts.
class MultipartReader {
 public:
  /// Bytes of a part's head, and parts, that are taken.
  static constexpr std::size_t kMaxHead = std::size_t{8} << 10;
  static constexpr std::size_t kMaxParts = 64;

  MultipartReader(std::string_view boundary, PartSink sink);

  /// invalid_request if the bytes break the rules, or the sink's error.
  Status feed(std::span<const std::byte> bytes);

  /// invalid_request if the body ended before its last boundary.
  Status finish() const;

 private:
  enum class State : std::uint8_t { before, after_boundary, head, body, over };

  /// Does what the buffer allows; false when more bytes are needed.
  Result<bool> step();
  Result<bool> skip_preamble();
  Result<bool> after_boundary();
  Result<bool> read_head();
  Result<bool> read_body();

  const std::string delimiter_;
  PartSink sink_;
  State state_ = State::before;
  // Begins with the line break that the first boundary lacks.
  std::string buffer_ = "\r\n";
  std::size_t parts_ = 0;
};

}  // namespace surfaced::http
