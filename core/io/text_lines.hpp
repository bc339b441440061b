// SPDX-License-Identifier: GPL-3.0-or-later
// Text inputs line by line, and lines as columns.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "io/bytes.hpp"

namespace surfaced::io {

/// Lines of an input, whatever ends them: LF, CRLF or CR.
class TextLines {
 public:
  /// A longer line is refused, so that a file's window stays small.
  static constexpr std::size_t kLongest = std::size_t{64} << 10;

  TextLines(ByteSource& source, std::string_view name) : source_(source), name_(name) {}

  /// Moves to the next line; false at the end of the input. malformed_input for a line that is too long,
  /// input_unreadable where the file cannot be read on.
  Result<bool> next();

  /// The line without its end and the blanks around it; lives until the next call of next().
  std::string_view text() const { return text_; }
  /// The same with its blanks: a tab at the beginning separates.
  std::string_view raw() const { return raw_; }
  /// Counted from 1.
  std::uint64_t number() const { return number_; }

  /// An error that names the input and the line.
  Error error(ErrorCode code, const std::string& what) const;
  Error malformed(const std::string& what) const { return error(ErrorCode::malformed_input, what); }

 private:
  ByteSource& source_;
  std::string_view name_;
  std::string_view text_;
  std::string_view raw_;
  std::uint64_t number_ = 0;
};

/// The columns of a line.
class Columns {
 public:
  /// More columns than these are not kept, only counted.
  static constexpr std::size_t kMost = 64;

  /// Splits at runs of blanks, or at every `separator` if it is not a blank; blanks around a value are cut off, and so
  /// are quotes. One separator at the end of the line is none. With `quoted`, a separator between quotes is none
  /// either.
  void split(std::string_view line, char separator, bool quoted = false);

  /// Adds a value that is not in the line.
  void push_missing() { push_trimmed({}); }

  std::size_t count() const { return count_; }
  std::string_view operator[](std::size_t i) const { return values_[i]; }

 private:
  void push_trimmed(std::string_view value);

  std::array<std::string_view, kMost> values_;
  std::size_t count_ = 0;
};

/// Whether the line holds nothing but separators (two at least), blanks and empty quotes: a point without a
/// measurement.
bool is_empty_row(std::string_view line, char separator);

/// Cuts the first word, up to a blank, off the text.
std::string_view take_word(std::string_view& text);

std::string_view trimmed(std::string_view text);

}  // namespace surfaced::io
