// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/table_numbers.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <string>

#include "base/text.hpp"
#include "io/ply_ascii.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

std::string without(std::string_view text, char sign) {
  std::string kept;
  std::ranges::copy_if(text, std::back_inserter(kept), [&](char c) { return c != sign; });
  return kept;
}

/// The signs of C for the minus of typesetters and for the exponents of Fortran: 1.5D+00.
std::string with_plain_signs(std::string_view text) {
  constexpr std::string_view kMinus = "\xe2\x88\x92";
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool minus = text.substr(i).starts_with(kMinus);
    const bool exponent = i > 0 && i + 1 < text.size() && (text[i] == 'D' || text[i] == 'd') &&
                          (text[i + 1] == '+' || text[i + 1] == '-');
    plain += minus ? '-' : exponent ? 'e' : text[i];
    i += minus ? kMinus.size() - 1 : 0;
  }
  return plain;
}

/// A number that is written as programs for people write it: 1'234.5, 1 234.5, 1.234.567 with decimal commas elsewhere.
bool parse_unusual(std::string_view text, bool decimal_comma, double& value) {
  for (const char group : {'\'', ' '}) {
    if (is_grouped(text, group, '.')) return parse_number(without(text, group), Scalar::float64, value);
  }
  if (decimal_comma && is_grouped(text, '.', ',')) return parse_number(without(text, '.'), Scalar::float64, value);
  const std::string plain = with_plain_signs(text);
  return plain != text && parse_number(plain, Scalar::float64, value);
}

/// The number of a cell; what stands for no measurement is none here.
bool parse_value(std::string_view text, bool decimal_comma, double& value) {
  if (text.size() >= kTokenLimit) return false;
  if (parse_number(text, Scalar::float64, value)) return true;
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return parse_unusual(text, decimal_comma, value);
  std::string pointed(text);
  if (is_grouped(text, ',', '.') && text.find('.') != text.npos) {
    return parse_number(without(pointed, ','), Scalar::float64, value);
  }
  if (!decimal_comma) return false;
  for (const char group : {'.', '\'', ' '}) {
    if (is_grouped(text, group, ',')) pointed = without(pointed, group);
  }
  pointed[pointed.find(',')] = '.';
  return parse_number(pointed, Scalar::float64, value) || parse_unusual(pointed, false, value);
}

}  // namespace

bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_whole(std::string_view cell) {
  if (cell.starts_with('-') || cell.starts_with('+')) cell.remove_prefix(1);
  return !cell.empty() && std::ranges::all_of(cell, is_digit);
}

bool is_grouped(std::string_view text, char group, char decimal) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  const std::string_view whole = text.substr(0, text.find(decimal));
  const std::string_view fraction = text.substr(std::min(whole.size() + 1, text.size()));
  const std::size_t first = whole.find(group);
  if (first == 0 || first > 3 || whole.size() <= first || !std::ranges::all_of(fraction, is_digit)) return false;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const bool sign = i >= first && (i - first) % 4 == 0;
    if (sign ? whole[i] != group : !is_digit(whole[i])) return false;
  }
  return (whole.size() - first) % 4 == 0;
}

bool has_decimal_comma(std::string_view cell) {
  const std::size_t comma = cell.find(',');
  return comma != std::string_view::npos && comma + 1 < cell.size() && is_digit(cell[comma + 1]) &&
         cell.find(',', comma + 1) == std::string_view::npos &&
         (cell.find('.') == std::string_view::npos || is_grouped(cell, '.', ','));
}

bool is_number(std::string_view cell, bool decimal_comma) {
  double value = 0;
  return parse_value(cell, decimal_comma, value);
}

bool is_value(std::string_view cell, bool decimal_comma) {
  double value = 0;
  return !cell.empty() && parse_cell(cell, decimal_comma, value);
}

bool parse_cell(std::string_view text, bool decimal_comma, double& value) {
  if (parse_value(text, decimal_comma, value)) return true;
  constexpr auto kNoMeasurement =
      std::to_array<std::string_view>({"", "-", "--", "na", "n/a", "#n/a", "null", "none", "nil", "nodata"});
  if (text.size() > 6 || std::ranges::find(kNoMeasurement, in_lower_case(text)) == kNoMeasurement.end()) return false;
  value = std::numeric_limits<double>::quiet_NaN();
  return true;
}

}  // namespace surfaced::io
