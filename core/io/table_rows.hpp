// SPDX-License-Identifier: GPL-3.0-or-later
// Where a table of text begins, and its first rows.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/io.hpp"

namespace surfaced::io {

/// In the order in which they are tried: a later one may stand within the values that an earlier one separates.
constexpr std::array<char, 5> kSeparators{'\t', ';', '|', ',', ' '};

using Cells = std::vector<std::string_view>;

/// The values of a line, Columns::kMost at most; a separator within quotes is none.
Cells cells_of(std::string_view line, char separator);

/// Numbers, and words for no measurement.
std::size_t count_values(const Cells& cells, bool decimal_comma);

char char_of(Separator separator);

/// The lines of a sample; the last one only if all of it is there.
std::vector<std::string_view> lines_of(std::string_view sample, bool whole);

struct TableStart {
  /// The line that names x, y and z.
  std::optional<std::string> header;
  /// The separator that a spreadsheet names in a line of its own.
  std::optional<char> hinted;
  /// Lines before the first row, or before the count of points before it.
  std::size_t skip = 0;
  /// Lines that were passed over although they are no comments; empty if there are none.
  std::string first_passed;
  std::string last_passed;
  /// kTableRows at most.
  std::vector<std::string_view> rows;
};

/// @return  unknown_format if there is neither a header nor a row, or if most of what follows the first row is none.
Result<TableStart> find_table(const std::vector<std::string_view>& lines, const TableOptions& options);

}  // namespace surfaced::io
