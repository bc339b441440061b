// SPDX-License-Identifier: GPL-3.0-or-later
// The data of an ascii PLY: one row a line, values apart by blanks.
#pragma once

#include <string>
#include <string_view>

#include "io/bytes.hpp"
#include "io/ply_header.hpp"

namespace surfaced::io {

/// Text of this length is no number any more; nobody writes more than 17 digits.
constexpr std::size_t kTokenLimit = 512;

class AsciiRows {
 public:
  explicit AsciiRows(ByteSource& source) : source_(source) {}

  /// Moves to the next line that is not blank; false at the end of the input.
  bool begin_row();

  /// Next value of the line as text, empty where the line ends. Lives until the next call. Longer text
  /// comes in pieces of kTokenLimit.
  std::string_view token();

  /// True if nothing but blanks is left of the line.
  bool at_line_end();

 private:
  /// Skips blanks; the byte after them, or nothing at the end of the input.
  std::string_view after_blanks();

  ByteSource& source_;
};

/// Reads a number of the declared type from text, whatever the locale: what a float property holds is
/// rounded to float32 at once; "nan" and "inf" in the spellings of C, C++ and Windows are numbers.
/// @return  false if the text is no number, or no whole number within the range of an integer type.
bool parse_number(std::string_view text, Scalar type, double& value);

}  // namespace surfaced::io
