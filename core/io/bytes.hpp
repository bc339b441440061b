// SPDX-License-Identifier: GPL-3.0-or-later
// Bytes of an input, from memory or streamed from a file, through one window.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/base.hpp"
#include "base/unique_fd.hpp"

namespace surfaced::io {

/// A forward reader. What it holds of a file is one block, however long the file is.
class ByteSource {
 public:
  explicit ByteSource(std::span<const std::byte> bytes) : cursor_(bytes.data()), end_(cursor_ + bytes.size()) {}

  /// Opens a file. Pipes and devices, whose length nobody knows, are read into memory first.
  static Result<ByteSource> open(const std::filesystem::path& path);

  /// Contiguous bytes from the cursor on: at least `wanted` of them unless the input ends before.
  /// `wanted` must not come from the input unchecked: a file's window grows to it.
  std::span<const std::byte> peek(std::size_t wanted) {
    if (static_cast<std::size_t>(end_ - cursor_) < wanted) refill(wanted);
    return {cursor_, end_};
  }

  /// Moves the cursor within what peek returned.
  void advance(std::size_t count) { cursor_ += count; }

  /// Moves the cursor by any distance; false, with the cursor at the end, if the input is shorter.
  bool skip(std::uint64_t count);

  /// Bytes from the cursor to the end of the input.
  std::uint64_t remaining() const { return static_cast<std::uint64_t>(end_ - cursor_) + unread_; }

  /// The rest of the input in one piece: the window of memory, or the file read into memory.
  std::span<const std::byte> rest() { return peek(static_cast<std::size_t>(remaining())); }

  /// Why the file could not be read on, if so; the input then seems to end there.
  const std::optional<Error>& failure() const { return failure_; }

 private:
  ByteSource() = default;
  void refill(std::size_t wanted);
  Status slurp(const std::filesystem::path& path);

  const std::byte* cursor_ = nullptr;
  const std::byte* end_ = nullptr;
  std::uint64_t unread_ = 0;
  UniqueFd file_;
  std::vector<std::byte> block_;
  std::optional<Error> failure_;
};

}  // namespace surfaced::io
