// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/chunk_guard.hpp"

#include <algorithm>

namespace surfaced::http {
namespace {

/// 2^60 bytes: beyond any body, and far from the end of 64 bits.
constexpr unsigned kMaxDigits = 15;
constexpr unsigned kMaxExtension = 256;

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

bool ChunkGuard::accept(std::string_view bytes) {
  while (!bytes.empty() && state_ != State::broken) {
    if (state_ == State::data) {
      const auto count = std::min<std::uint64_t>(left_, bytes.size());
      left_ -= count;
      bytes.remove_prefix(count);
      if (left_ == 0) state_ = State::data_cr;
    } else {
      state_ = step(bytes.front());
      bytes.remove_prefix(1);
    }
  }
  return state_ != State::broken;
}

ChunkGuard::State ChunkGuard::in_size(char byte) {
  const int digit = hex_value(byte);
  if (digit >= 0) {
    if (++digits_ > kMaxDigits) return State::broken;
    left_ = left_ * 16 + static_cast<unsigned>(digit);
    return State::size;
  }
  if (digits_ == 0) return State::broken;
  if (byte == ';') return State::extension;
  return byte == '\r' ? State::size_end : State::broken;
}

ChunkGuard::State ChunkGuard::step(char byte) {
  switch (state_) {
    case State::size:
      return in_size(byte);
    case State::extension:
      if (byte == '\r') return State::size_end;
      return byte == '\n' || ++extension_ > kMaxExtension ? State::broken : State::extension;
    case State::size_end:
      digits_ = extension_ = 0;
      if (byte != '\n') return State::broken;
      return left_ == 0 ? State::last_cr : State::data;
    case State::data_cr:
      return byte == '\r' ? State::data_lf : State::broken;
    case State::data_lf:
      return byte == '\n' ? State::size : State::broken;
    case State::last_cr:
      return byte == '\r' ? State::last_lf : State::broken;
    case State::last_lf:
      return byte == '\n' ? State::complete : State::broken;
    default:
      return State::broken;
  }
}

}  // namespace surfaced::http
