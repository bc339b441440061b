// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string_view>

namespace surfaced::http {

/// Watches the raw bytes of a chunked body and says whether they keep to RFC 9112, before the decoder
/// of the library sees them: that one takes signs and 0x in sizes, ends quietly where the line end
/// after a chunk is missing, and has no limit on the length of a line. Trailer fields are refused.
class ChunkGuard {
 public:
  /// False once the bytes break the rules.
  bool accept(std::string_view bytes);
  /// True once the last chunk has passed, complete.
  bool complete() const { return state_ == State::complete; }

 private:
  enum class State : std::uint8_t {
    size,
    extension,
    size_end,
    data,
    data_cr,
    data_lf,
    last_cr,
    last_lf,
    complete,
    broken
  };
  State step(char byte);
  State in_size(char byte);

  State state_ = State::size;
  std::uint64_t left_ = 0;
  unsigned digits_ = 0;
  unsigned extension_ = 0;
};

}  // namespace surfaced::http
