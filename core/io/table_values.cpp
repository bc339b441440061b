// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/table_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace surfaced::io {
namespace {

/// How far from 1 the length of what counts as a normal may be: files round to as little as two digits.
constexpr double kNormalSlack = 0.1;
/// Rows from which on a column may be said to count.
constexpr std::size_t kFewestCounted = 3;
/// Points that were deleted leave gaps; this is the mean step, where there are rows enough to tell it from chance.
constexpr double kLargestStep = 4;
constexpr std::size_t kFewestWithGaps = 16;
/// Classes, returns and counts of returns of laser scanners are no larger; colours are, somewhere in a cloud.
constexpr double kLargestClass = 31;
constexpr double kMostReturns = 15;
/// The channels of a colour are like one another, an intensity is not so like them.
constexpr double kClearlyGreyer = 0.75;

bool is_constant(const ColumnValues& column) {
  return std::ranges::all_of(column.values, [&](double x) { return x == column.values.front(); });
}

bool within(const ColumnValues& column, double low, double high) {
  return std::ranges::all_of(column.values, [&](double x) { return std::isnan(x) || (x >= low && x <= high); });
}

bool has_fractions(const ColumnValues& column) {
  return std::ranges::any_of(column.values, [](double x) { return std::isfinite(x) && x != std::floor(x); });
}

/// Whole, and no two the same.
bool are_identifiers(const ColumnValues& column) {
  if (!column.numeric || column.values.size() < kFewestCounted) return false;
  std::vector<double> sorted = column.values;
  const bool whole = std::ranges::all_of(sorted, [](double x) { return x >= 0 && x == std::floor(x); });
  if (!whole) return false;
  std::ranges::sort(sorted);
  return std::ranges::adjacent_find(sorted) == sorted.end();
}

double largest(const ColumnValues& column) {
  double most = -std::numeric_limits<double>::infinity();
  for (const double x : column.values) most = std::isnan(x) ? most : std::max(most, x);
  return most;
}

/// Northing and easting as zones of transverse Mercator projections give them, in this order.
bool are_north_and_east(const ColumnValues& first, const ColumnValues& second) {
  return within(first, 1e6, 1e7) && within(second, 1e5, 999'999);
}

std::array<double, 3> three_of(const std::vector<ColumnValues>& columns, std::size_t first, std::size_t row) {
  return {columns[first].values[row], columns[first + 1].values[row], columns[first + 2].values[row]};
}

/// Whether it is so in all rows that have the three values, and there are some.
template <class Is>
bool all_rows(const std::vector<ColumnValues>& columns, std::size_t first, Is is) {
  bool some = false;
  for (std::size_t row = 0; row < columns[first].values.size(); ++row) {
    const auto values = three_of(columns, first, row);
    if (are_missing(values)) continue;
    if (!is(values)) return false;
    some = true;
  }
  return some;
}

std::size_t count_distinct(const ColumnValues& column) {
  std::vector<double> sorted = column.values;
  std::erase_if(sorted, [](double x) { return std::isnan(x); });
  std::ranges::sort(sorted);
  return static_cast<std::size_t>(std::unique(sorted.begin(), sorted.end()) - sorted.begin());
}

/// Number of a return and number of returns.
bool are_returns(const ColumnValues& number, const ColumnValues& count) {
  if (!within(number, 1, kMostReturns) || !within(count, 1, kMostReturns)) return false;
  for (std::size_t row = 0; row < number.values.size(); ++row) {
    if (number.values[row] > count.values[row]) return false;
  }
  return true;
}

/// Whether a column of few small numbers that come again stands beside such as have more of them, or fewer: a class
/// beside an intensity or the number of a scan. The channels of a colour vary together.
bool has_class_beside(const std::vector<ColumnValues>& columns, std::size_t first) {
  std::array<std::size_t, 3> distinct{};
  for (std::size_t i = 0; i < 3; ++i) distinct.at(i) = count_distinct(columns[first + i]);
  const auto is_dark = [&](std::size_t i) { return largest(columns[first + i]) <= kLargestClass; };
  for (std::size_t c = 0; c < 3; ++c) {
    const bool repeats = 2 * distinct.at(c) <= columns[first + c].values.size() + 2;
    if (!is_dark(c) || !repeats || largest(columns[first + c]) < 1) continue;
    bool alone = true;
    for (std::size_t i = 0; i < 3; ++i) alone &= is_dark(i) || distinct.at(i) != distinct.at(c);
    if (alone) return true;
  }
  // One that varies beside two that stay.
  return std::ranges::count(distinct, 1U) == 2 && std::ranges::max(distinct) >= kFewestCounted;
}

/// Class, return, number of returns, number of a scan, and what else is whole and small.
bool are_classes(const std::vector<ColumnValues>& columns, std::size_t first) {
  const auto most = std::max({largest(columns[first]), largest(columns[first + 1]), largest(columns[first + 2])});
  if (most <= kLargestClass) return true;
  if (are_returns(columns[first], columns[first + 1]) || are_returns(columns[first + 1], columns[first + 2]))
    return true;
  return columns[first].values.size() >= kFewestCounted && has_class_beside(columns, first);
}

/// How far the channels are from one another, on average.
double spread(const std::vector<ColumnValues>& columns, std::size_t first) {
  double sum = 0;
  for (std::size_t row = 0; row < columns[first].values.size(); ++row) {
    const auto values = three_of(columns, first, row);
    if (!are_missing(values)) sum += std::ranges::max(values) - std::ranges::min(values);
  }
  return sum;
}

class Groups {
 public:
  Groups(const std::vector<ColumnValues>& columns, std::vector<Role>& roles) : columns_(columns), roles_(roles) {}

  void take_normals() {
    for (std::size_t c = 0; c + 3 <= columns_.size(); ++c) {
      if (!is_free(c) || !all_rows(columns_, c, is_normal)) continue;
      take(c, Role::nx);
      return;
    }
  }

  /// Where more than three neighbours would do, an intensity or opacity stands before or behind the colour: the colour
  /// are those three of which all may be more than a class; of several the last, unless what follows is opaque, or an
  /// earlier one is clearly closer to grey.
  void take_colors() {
    std::optional<std::size_t> best;
    for (std::size_t c = 0; c + 3 <= columns_.size(); ++c) {
      if (!is_free(c) || !all_rows(columns_, c, is_color) || are_classes(columns_, c)) continue;
      if (best && (rank(c) < rank(*best) || (*best + 1 == c && is_opaque(c + 2)))) continue;
      if (best && rank(c) == rank(*best) && spread(columns_, *best) < kClearlyGreyer * spread(columns_, c)) continue;
      best = c;
    }
    if (best) take(*best, Role::r);
  }

 private:
  bool is_free(std::size_t first) const {
    for (std::size_t c = first; c < first + 3; ++c) {
      if (roles_[c] != Role::none || !columns_[c].numeric) return false;
    }
    return true;
  }
  /// Whether every channel may be more than a class: only that counts, not how bright it is.
  int rank(std::size_t first) const {
    int all = 1;
    for (std::size_t c = first; c < first + 3; ++c) all = largest(columns_[c]) > kLargestClass ? all : 0;
    return all;
  }
  bool is_opaque(std::size_t c) const { return is_constant(columns_[c]) && columns_[c].values.front() == 255; }
  void take(std::size_t first, Role role) {
    for (std::size_t i = 0; i < 3; ++i) {
      roles_[first + i] = static_cast<Role>(static_cast<std::size_t>(role) + i);
    }
  }

  const std::vector<ColumnValues>& columns_;
  std::vector<Role>& roles_;
};

}  // namespace

bool are_missing(const std::array<double, 3>& v) {
  return std::ranges::all_of(v, [](double x) { return std::isnan(x); });
}

bool is_normal(const std::array<double, 3>& v) { return std::abs(std::hypot(v[0], v[1], v[2]) - 1) <= kNormalSlack; }

bool is_color(const std::array<double, 3>& v) {
  return std::ranges::all_of(v, [](double x) { return x >= 0 && x <= 255 && x == std::floor(x); });
}

bool counts_up(const ColumnValues& column) {
  if (!column.numeric || column.values.size() < kFewestCounted) return false;
  const double first = column.values.front();
  if (!(first >= 0) || first != std::floor(first)) return false;
  for (std::size_t row = 1; row < column.values.size(); ++row) {
    const double x = column.values[row];
    if (!(x > column.values[row - 1]) || x != std::floor(x)) return false;
  }
  const double step = column.values.size() < kFewestWithGaps ? 1 : kLargestStep;
  return column.values.back() - first <= step * static_cast<double>(column.values.size() - 1);
}

/// Whether the first of the columns with numbers holds those of the points. A line of a raster counts too, beside a
/// column that stays.
bool begins_with_numbers_of_points(const std::vector<ColumnValues>& columns, const std::vector<std::size_t>& numbers) {
  if (numbers.size() < 4 || is_constant(columns[numbers[1]])) return false;
  if (counts_up(columns[numbers[0]])) return true;
  return are_identifiers(columns[numbers[0]]) && std::all_of(numbers.begin() + 1, numbers.begin() + 4,
                                                             [&](std::size_t c) { return has_fractions(columns[c]); });
}

std::vector<Role> roles_by_values(const std::vector<ColumnValues>& columns) {
  std::vector<std::size_t> numbers;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (columns[c].numeric) numbers.push_back(c);
  }
  std::vector<Role> roles(columns.size(), Role::none);
  if (begins_with_numbers_of_points(columns, numbers)) numbers.erase(numbers.begin());
  if (numbers.size() < 3) return roles;
  if (are_north_and_east(columns[numbers[0]], columns[numbers[1]])) std::swap(numbers[0], numbers[1]);
  for (std::size_t i = 0; i < 3; ++i) roles[numbers[i]] = static_cast<Role>(i);
  Groups groups(columns, roles);
  groups.take_normals();
  groups.take_colors();
  return roles;
}

}  // namespace surfaced::io
