// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers as tables of text have them.
#pragma once

#include <string_view>

namespace surfaced::io {

bool is_digit(char c);

/// Digits alone, perhaps behind a sign.
bool is_whole(std::string_view cell);

/// Digits in groups of three by `group`, at least two of them, and perhaps a decimal sign and more digits.
bool is_grouped(std::string_view text, char group, char decimal);

/// Digits, a comma, digits; perhaps with points between thousands.
bool has_decimal_comma(std::string_view cell);

/// Whether the cell is a number, nan included; what stands for no measurement is none.
bool is_number(std::string_view cell, bool decimal_comma);

/// Whether the cell is a number or a word for no measurement.
bool is_value(std::string_view cell, bool decimal_comma);

/// A number of a table. What stands for no measurement (nothing, NA, null, -) is NaN.
bool parse_cell(std::string_view text, bool decimal_comma, double& value);

}  // namespace surfaced::io
