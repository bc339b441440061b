// SPDX-License-Identifier: GPL-3.0-or-later
// How a table of text is made: what separates its values, what its columns are. Told from its beginning alone, so that
// the viewer, which tells it by the same rules (server/web/src/clouds/table.ts, tests/support/tables.json), and every
// reader agree.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/io.hpp"
#include "io/table_names.hpp"

namespace surfaced::io {

/// So much of a file is looked at, and so many of its rows.
constexpr std::size_t kTableSample = std::size_t{64} << 10;
constexpr std::size_t kTableRows = 1000;

struct TableForm {
  /// A blank stands for any run of blanks and tabs.
  char separator = ' ';
  /// A comma in a number is its decimal point.
  bool decimal_comma = false;
  /// Values may stand in quotes.
  bool quotes = false;
  /// Lines before the first row, or before the count of points before it.
  std::size_t skip = 0;
  /// Of every column of the first row.
  std::vector<Role> roles;
  /// What the header calls them; empty without one.
  std::vector<std::string> names;
  /// Whether all rows must have as many values as the first: where all of them are numbers and nothing names them.
  bool strict = false;
  /// Whether normals and colours were told by their values, which then are to be so in all rows.
  bool by_values = false;
  /// Whether anything was guessed that is not plain x y z.
  bool guessed = false;
  /// The first line that was passed over although it is no comment; empty if there is none.
  std::string passed_over;
};

/// @param sample  the beginning of the text, up to kTableSample bytes of it.
/// @param whole   whether that is all there is.
/// @return  unknown_format if there are no rows of numbers; missing_positions, unsupported_feature, malformed_input for
/// a
///          table that cannot be read as it is; invalid_parameter for options that do not fit it.
Result<TableForm> guess_table(std::string_view sample, bool whole, std::string_view name, const TableOptions& options);

/// Whether the line is a comment: # or //, and what stands behind the mark.
bool is_comment(std::string_view line);
std::string_view without_mark(std::string_view line);

}  // namespace surfaced::io
