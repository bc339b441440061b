// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/table_guess.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "io/table_numbers.hpp"
#include "io/table_rows.hpp"
#include "io/table_values.hpp"
#include "io/text.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

/// Signs alone, as `;` or `--`.
bool is_mark(std::string_view cell) {
  return std::ranges::none_of(cell, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c < 0; });
}

class Guesser {
 public:
  Guesser(std::string_view name, const TableOptions& options) : name_(name), options_(options) {}

  Result<TableForm> run(const std::vector<std::string_view>& lines) {
    if (Status given = take_options(); !given) return std::move(given).error();
    Result<TableStart> found = find_table(lines, options_);
    if (!found) return no_table(lines, found.error());
    start_ = std::move(*found);
    form_.skip = start_.skip;
    form_.passed_over = start_.first_passed;
    if (Status told = tell_separator(); !told) return std::move(told).error();
    if (Status told = tell_columns(); !told) return std::move(told).error();
    return std::move(form_);
  }

 private:
  Error error(ErrorCode code, const std::string& what) const { return {code, std::string(name_) + ": " + what}; }

  Error no_table(const std::vector<std::string_view>& lines, const Error& error) const {
    const auto first = std::ranges::find_if(lines, [](std::string_view line) { return !trimmed(line).empty(); });
    return {error.code, std::string(name_) + " is text, but no table of points: " + error.detail +
                            (first == lines.end() ? "" : "; it begins with " + in_quotes(trimmed(*first)))};
  }

  Status take_options() {
    if (options_.columns.empty()) return Done{};
    roles_ = roles_named(options_.columns);
    if (roles_) return Done{};
    return with_fault(error(ErrorCode::invalid_parameter,
                            "columns=" + in_quotes(options_.columns) +
                                " is no list of x, y, z, nx, ny, nz, r, g, b and - with x, y and z in it, each once"),
                      {"columns", options_.columns, "names such as -,x,y,z,r,g,b"});
  }

  /// The first with three values, or else with anything, once the separator is known.
  std::string_view first_row() const {
    const auto with = [&](std::size_t least) {
      return std::ranges::find_if(start_.rows, [&](std::string_view row) {
        return count_values(cells_of(row, form_.separator), true) >= least;
      });
    };
    for (const std::size_t least : {3U, 1U}) {
      if (const auto found = with(least); found != start_.rows.end()) return *found;
    }
    return start_.rows.front();
  }

  // Step 2: what separates the values. Reads start_.rows; writes form_.separator, quotes, decimal_comma.
  Status tell_separator() {
    form_.quotes = std::ranges::any_of(start_.rows, [](std::string_view row) { return row.find('"') != row.npos; });
    form_.separator = options_.separator != Separator::guessed ? char_of(options_.separator)
                      : start_.hinted                          ? *start_.hinted
                      : start_.rows.empty()                    ? separator_of_header()
                                                               : guessed_separator();
    if (options_.decimal != Decimal::guessed) {
      form_.decimal_comma = options_.decimal == Decimal::comma;
      return Done{};
    }
    std::string_view thousands;
    for (const std::string_view row : start_.rows) {
      for (const std::string_view cell : cells_of(row, form_.separator)) {
        form_.decimal_comma |= has_decimal_comma(cell) && is_number(cell, true);
        if (cell.find('.') != cell.npos && is_grouped(cell, ',', '.')) thousands = row;
      }
    }
    if (form_.decimal_comma && !thousands.empty()) {
      return error(ErrorCode::malformed_input,
                   "its commas stand between thousands in " + in_quotes(thousands) +
                       ", and seem to be decimal commas elsewhere; write it without thousands "
                       "separators (decimal=comma takes the others as decimal commas)");
    }
    form_.guessed |= form_.decimal_comma || !thousands.empty();
    return check_commas();
  }

  char separator_of_header() const {
    for (const char separator : kSeparators) {
      if (meaning_of(cells_of(without_units(*start_.header), separator)).has_position) return separator;
    }
    return ' ';
  }

  /// The first that leaves three numbers in nine of ten rows.
  char guessed_separator() const {
    for (const char separator : kSeparators) {
      const auto bad = static_cast<std::size_t>(std::ranges::count_if(start_.rows, [&](std::string_view row) {
        return !is_empty_row(row, separator) && count_values(cells_of(row, separator), separator != ',') < 3;
      }));
      if (10 * bad <= start_.rows.size()) return separator;
    }
    for (const char separator : {'\t', ';', '|', ','}) {
      if (first_row().find(separator) != std::string_view::npos) return separator;
    }
    return ' ';
  }

  /// Commas may separate, or stand within numbers; where they do both, nobody can tell.
  Status check_commas() const {
    if (form_.separator != ',' || form_.quotes || form_.decimal_comma || roles_ ||
        options_.separator != Separator::guessed)
      return Done{};
    bool fraction = false;
    for (const std::string_view row : start_.rows) {
      const Cells cells = cells_of(row, ',');
      if (cells.size() < 6 || cells.size() % 2 != 0 || !std::ranges::all_of(cells, is_whole)) return Done{};
      for (std::size_t i = 1; i < cells.size(); i += 2) {
        if (!is_digit(cells[i].front())) return Done{};
        fraction |= cells[i].size() > 1 && cells[i].front() == '0';
      }
    }
    if (!fraction) return Done{};
    return error(ErrorCode::malformed_input,
                 "its commas separate values and seem to be decimal commas as well: " + in_quotes(first_row()) +
                     "; write it with semicolons or tabs between the values, or with "
                     "decimal points (separator=comma takes every comma as a separator)");
  }

  // Step 3: what the columns are. Reads all of the above; writes form_.roles, names, strict, by_values.
  Status tell_columns() {
    const std::size_t columns = start_.rows.empty() ? 0 : columns_of_first_row();
    if (roles_) return take_named(columns);
    if (start_.header) return take_header_roles(columns);
    std::vector<ColumnValues> values = values_of(columns);
    form_.roles = roles_by_values(values);
    if (std::ranges::find(form_.roles, Role::x) == form_.roles.end()) {
      // The first row decides, so that a later one that breaks the table is named where it is read.
      const Cells cells = cells_of(first_row(), form_.separator);
      for (std::size_t c = 0; c < columns; ++c) values[c].numeric = is_number(cells[c], form_.decimal_comma);
      form_.roles = roles_by_values(values);
    }
    if (std::ranges::find(form_.roles, Role::x) == form_.roles.end()) return no_columns(columns);
    if (Status unnamed = check_passed_over(columns); !unnamed) return unnamed;
    form_.strict =
        columns < Columns::kMost && std::ranges::all_of(values, &ColumnValues::numeric) && !has_words_behind(columns);
    form_.by_values = true;
    form_.guessed |= columns > 3;
    return Done{};
  }

  /// A separator at its end is one more, where the header has a name for it.
  std::size_t columns_of_first_row() const {
    const std::size_t columns = cells_of(first_row(), form_.separator).size();
    const bool open = form_.separator != ' ' && first_row().ends_with(form_.separator);
    return open && start_.header && cells_of(*start_.header, form_.separator).size() == columns + 1 ? columns + 1
                                                                                                    : columns;
  }

  Status take_named(std::size_t columns) {
    form_.roles = *roles_;
    form_.guessed = false;
    if (start_.header) take_names(cells_of(*start_.header, form_.separator), columns);
    if (columns >= roles_->size() || start_.rows.empty()) {
      form_.roles.resize(std::max(columns, roles_->size()), Role::none);
      return Done{};
    }
    return with_fault(
        error(ErrorCode::invalid_parameter, "columns=" + options_.columns + " names " + std::to_string(roles_->size()) +
                                                " columns; the first row has " + std::to_string(columns) + ": " +
                                                in_quotes(first_row())),
        {"columns", options_.columns, "as many names as there are columns, or fewer"});
  }

  /// The header's cells as the rows have them: names may hold blanks, rows may begin with a name of their own.
  Status take_header_roles(std::size_t columns) {
    const std::string text = without_units(*start_.header);
    HeaderMeaning best;
    Cells names;
    for (const char separator : {form_.separator, '\t', ';', '|', ',', ' '}) {
      Cells cells = cells_of(text, separator);
      HeaderMeaning meaning = meaning_of(cells);
      if (!meaning.has_position && !meaning.degrees) continue;
      const bool first = names.empty();
      if (!first && cells.size() != columns) continue;
      best = std::move(meaning);
      names = std::move(cells);
      if (names.size() == columns) break;
    }
    if (best.degrees) return degrees();
    // A mark of a comment that is not one of ours.
    if (names.size() == columns + 1 && columns > 0 && is_mark(names.front())) {
      best.roles.erase(best.roles.begin());
      names.erase(names.begin());
    }
    if (names.size() + 1 == columns && !start_.rows.empty()) {
      best.roles.insert(best.roles.begin(), Role::none);
      names.insert(names.begin(), std::string_view());
      form_.guessed = true;
    }
    form_.roles = std::move(best.roles);
    take_names(names, columns);
    form_.guessed |= best.synonyms;
    return check_header(columns);
  }

  /// More names than columns: some of them hold blanks, and those before them count.
  Status check_header(std::size_t columns) {
    if (start_.rows.empty() || form_.roles.size() == columns) return Done{};
    std::size_t known = 0;
    while (known < form_.roles.size() && form_.roles[known] != Role::none) ++known;
    form_.guessed = true;
    const std::span<const Role> first(form_.roles.data(), known);
    const auto has = [&](Role role) { return std::ranges::find(first, role) != first.end(); };
    if (known <= columns && has(Role::x) && has(Role::y) && has(Role::z)) {
      form_.roles.resize(known);
      form_.roles.resize(columns, Role::none);
      return Done{};
    }
    return error(ErrorCode::malformed_input, "its header names " + std::to_string(form_.roles.size()) +
                                                 " columns, its first row has " + std::to_string(columns) + ": " +
                                                 in_quotes(*start_.header) + ", " + in_quotes(first_row()) +
                                                 "; columns=x,y,z says which they are");
  }

  void take_names(const Cells& cells, std::size_t columns) {
    form_.names.assign(cells.begin(), cells.end());
    form_.names.resize(std::max(columns, cells.size()));
  }

  Error degrees() const {
    return error(ErrorCode::unsupported_feature,
                 "its columns are longitude and latitude, which are angles: as x and y they would be squeezed and as "
                 "small as the height is large; project the points to metres (UTM, for example) first, or take them as "
                 "they are with columns=x,y,z");
  }

  Error no_columns(std::size_t columns) const {
    return error(ErrorCode::missing_positions, "no three of its " + std::to_string(columns) +
                                                   " columns hold numbers throughout; the first row is " +
                                                   in_quotes(first_row()));
  }

  /// A line of as many words as there are columns, just before them, is a header that nobody understands.
  Status check_passed_over(std::size_t columns) const {
    if (start_.last_passed.empty()) return Done{};
    const Cells cells = cells_of(start_.last_passed, form_.separator);
    if (cells.size() != columns || count_values(cells, true) > 0) return Done{};
    std::string found;
    for (const std::string_view cell : cells) found += (found.empty() ? "" : ", ") + in_quotes(cell);
    return error(
        ErrorCode::missing_positions,
        "no columns x, y, z; found: " + found + "; columns=x,y,z, with - for a column to leave, says which they are");
  }

  /// Whether rows have text behind as many columns as the first has.
  bool has_words_behind(std::size_t columns) const {
    return std::ranges::any_of(start_.rows, [&](std::string_view row) {
      const Cells cells = cells_of(row, form_.separator);
      return cells.size() > columns && !is_value(cells[columns], form_.decimal_comma);
    });
  }

  std::vector<ColumnValues> values_of(std::size_t columns) const {
    std::vector<ColumnValues> values(columns);
    for (const std::string_view row : start_.rows) {
      if (is_empty_row(row, form_.separator)) continue;
      const Cells cells = cells_of(row, form_.separator);
      for (std::size_t c = 0; c < columns; ++c) {
        double value = std::numeric_limits<double>::quiet_NaN();
        if (c < cells.size() && !parse_cell(cells[c], form_.decimal_comma, value)) values[c].numeric = false;
        values[c].values.push_back(value);
      }
    }
    for (ColumnValues& column : values) {
      column.numeric &= std::ranges::any_of(column.values, [](double x) { return x == x; });
    }
    return values;
  }

  std::string_view name_;
  const TableOptions& options_;
  std::optional<std::vector<Role>> roles_;
  TableStart start_;
  TableForm form_;
};

}  // namespace

Result<TableForm> guess_table(std::string_view sample, bool whole, std::string_view name, const TableOptions& options) {
  return Guesser(name, options).run(lines_of(sample, whole));
}

}  // namespace surfaced::io
