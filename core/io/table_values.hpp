// SPDX-License-Identifier: GPL-3.0-or-later
// What the columns of a table without names are, told by their values.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "io/table_names.hpp"

namespace surfaced::io {

/// A column of the rows that were looked at.
struct ColumnValues {
  /// NaN where there is no number.
  std::vector<double> values;
  /// Every value is a number, or stands for no measurement.
  bool numeric = true;
};

/// Whether none of three values was measured.
bool are_missing(const std::array<double, 3>& v);
/// Whether three values are a normal: a vector of length 1, as files round it.
bool is_normal(const std::array<double, 3>& v);
/// Whether three values are a colour: whole numbers from 0 to 255.
bool is_color(const std::array<double, 3>& v);

/// Roles of the columns: the first three that hold numbers are the position, behind a first column of numbers of points
/// (they count up, or are whole and each its own before three columns with fractions); among the others, three
/// neighbours are normals or colours if all of their values are, and colours only if they vary together: not a class
/// beside an intensity.
/// @return  a role for every column; all none if there are not three columns of numbers.
std::vector<Role> roles_by_values(const std::vector<ColumnValues>& columns);

/// Whether the values count up, by one but for some gaps, as numbers of points do.
bool counts_up(const ColumnValues& column);

}  // namespace surfaced::io
