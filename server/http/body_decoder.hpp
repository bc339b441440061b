// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>

#include "http/request_head.hpp"

namespace surfaced::http {

/// Decodes the bodies of requests with cpp-httplib, which is used here and nowhere else: what it does for us, what it
/// is kept from and why stands in README.md. Safe in threads.
class BodyDecoder {
 public:
  /// As recv: the number of raw bytes, less than 1 once there are no more.
  using Source = std::function<std::ptrdiff_t(char* bytes, std::size_t size)>;
  /// False ends the reading.
  using Sink = std::function<bool(std::string_view decoded)>;

  BodyDecoder();
  ~BodyDecoder();
  BodyDecoder(const BodyDecoder&) = delete;
  BodyDecoder& operator=(const BodyDecoder&) = delete;

  /// Hands the body to the sink until its end, which the framing tells. What the sink throws gets through.
  /// @return  false if the source or the sink ended before
  bool decode(const Framing& framing, const Source& source, const Sink& sink) const;

 private:
  class Library;
  const std::unique_ptr<Library> library_;
};

}  // namespace surfaced::http
