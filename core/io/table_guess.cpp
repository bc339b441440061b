// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/table_guess.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <optional>
#include <utility>

#include "io/table_numbers.hpp"
#include "io/table_values.hpp"
#include "io/text.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

/// Lines of text that may stand before a table.
constexpr std::size_t kMostPreamble = 20;
/// In the order in which they are tried: a later one may stand within the values that an earlier one separates.
constexpr std::array<char, 5> kSeparators{'\t', ';', '|', ',', ' '};

using Cells = std::vector<std::string_view>;

Cells cells_of(std::string_view line, char separator) {
  Columns columns;
  columns.split(line, separator, true);
  Cells cells;
  for (std::size_t i = 0; i < std::min(columns.count(), Columns::kMost); ++i) cells.push_back(columns[i]);
  return cells;
}

/// Numbers, and words for no measurement.
std::size_t count_values(const Cells& cells, bool decimal_comma) {
  return static_cast<std::size_t>(
      std::ranges::count_if(cells, [&](auto cell) { return is_value(cell, decimal_comma); }));
}

/// Signs alone, as `;` or `--`.
bool is_mark(std::string_view cell) {
  return std::ranges::none_of(cell, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c < 0; });
}

char char_of(Separator separator) {
  switch (separator) {
    case Separator::tab:
      return '\t';
    case Separator::comma:
      return ',';
    case Separator::semicolon:
      return ';';
    case Separator::bar:
      return '|';
    default:
      return ' ';
  }
}

/// The lines of a sample; the last one only if all of it is there.
std::vector<std::string_view> lines_of(std::string_view sample, bool whole) {
  std::vector<std::string_view> lines;
  while (!sample.empty()) {
    const std::size_t end = sample.find_first_of("\r\n");
    if (end == std::string_view::npos && !whole && !lines.empty()) break;
    lines.push_back(sample.substr(0, end));
    if (end == std::string_view::npos) break;
    sample.remove_prefix(end + (sample.substr(end).starts_with("\r\n") ? 2U : 1U));
  }
  return lines;
}

class Guesser {
 public:
  Guesser(std::string_view name, const TableOptions& options) : name_(name), options_(options) {}

  Result<TableForm> run(const std::vector<std::string_view>& lines) {
    if (Status given = take_options(); !given) return std::move(given).error();
    if (Status found = find_table(lines); !found) return std::move(found).error();
    if (Status told = tell_separator(); !told) return std::move(told).error();
    if (Status told = tell_columns(); !told) return std::move(told).error();
    return std::move(form_);
  }

 private:
  Error error(ErrorCode code, const std::string& what) const { return {code, std::string(name_) + ": " + what}; }

  Status take_options() {
    if (options_.columns.empty()) return Done{};
    roles_ = roles_named(options_.columns);
    if (roles_) return Done{};
    return with_fault(error(ErrorCode::invalid_parameter,
                            "columns=" + in_quotes(options_.columns) +
                                " is no list of x, y, z, nx, ny, nz, r, g, b and - with x, y and z in it, each once"),
                      {"columns", options_.columns, "names such as -,x,y,z,r,g,b"});
  }

  // Step 1: where the table begins. Reads the lines; writes header_, rows_, form_.skip, form_.passed_over.
  Status find_table(const std::vector<std::string_view>& lines) {
    form_.skip = options_.skip;
    std::size_t preamble = 0;
    std::size_t at = std::min(options_.skip, lines.size());
    for (; at < lines.size() && preamble <= kMostPreamble; ++at) {
      const std::string_view line = trimmed(lines[at]);
      if (line.empty() || is_whole(line)) continue;  // a number alone is a count of points
      const bool comment = is_comment(line);
      if (!comment && looks_like_row(line)) break;
      const bool known = (!comment && take_hint(line)) || take_header(comment ? without_mark(line) : lines[at]);
      if (known || !comment) form_.skip = at + 1;
      if (known || comment) continue;
      pass_over(line);
      ++preamble;
    }
    if (preamble > kMostPreamble) at = lines.size();  // prose
    for (; at < lines.size() && rows_.size() < kTableRows; ++at) {
      const std::string_view line = trimmed(lines[at]);
      if (!line.empty() && !is_comment(line) && !is_whole(line)) rows_.push_back(lines[at]);
    }
    if (!rows_.empty() || header_) return Done{};
    return error(ErrorCode::unknown_format, "no line of its text holds three numbers");
  }

  /// Spreadsheets name the separator in a line of its own.
  bool take_hint(std::string_view line) {
    if (line.size() != 5 || in_lower_case(line.substr(0, 4)) != "sep=") return false;
    hinted_ = line[4];
    return true;
  }

  /// Three numbers, whatever separates them; perhaps text beside them. Behind a header one is enough: values may miss.
  bool looks_like_row(std::string_view line) const {
    const std::size_t least = header_ ? 1 : 3;
    if (options_.separator != Separator::guessed)
      return count_values(cells_of(line, char_of(options_.separator)), true) >= least;
    return std::ranges::any_of(kSeparators, [&](char s) { return count_values(cells_of(line, s), true) >= least; });
  }

  /// Whether the line names x, y and z, whatever separates the names.
  bool take_header(std::string_view line) {
    constexpr std::size_t kMostTries = 100;
    if (header_ || line.size() < 5 || ++tries_ > kMostTries) return false;
    for (const char separator : kSeparators) {
      const std::string text = without_units(line);
      const HeaderMeaning meaning = meaning_of(cells_of(text, separator));
      if (!meaning.has_position && !meaning.degrees) continue;
      header_ = std::string(line);
      return true;
    }
    return false;
  }

  void pass_over(std::string_view line) {
    if (form_.passed_over.empty()) form_.passed_over = line;
    last_passed_ = line;
  }

  // Step 2: what separates the values. Reads rows_; writes form_.separator, quotes, decimal_comma.
  Status tell_separator() {
    form_.quotes = std::ranges::any_of(rows_, [](std::string_view row) { return row.find('"') != row.npos; });
    form_.separator = options_.separator != Separator::guessed ? char_of(options_.separator)
                      : hinted_                                ? *hinted_
                      : rows_.empty()                          ? separator_of_header()
                                                               : guessed_separator();
    if (options_.decimal != Decimal::guessed) {
      form_.decimal_comma = options_.decimal == Decimal::comma;
      return Done{};
    }
    std::string_view thousands;
    for (const std::string_view row : rows_) {
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
      if (meaning_of(cells_of(without_units(*header_), separator)).has_position) return separator;
    }
    return ' ';
  }

  /// The first that leaves three numbers in nine of ten rows.
  char guessed_separator() const {
    for (const char separator : kSeparators) {
      const auto bad = static_cast<std::size_t>(std::ranges::count_if(
          rows_, [&](std::string_view row) { return count_values(cells_of(row, separator), separator != ',') < 3; }));
      if (10 * bad <= rows_.size()) return separator;
    }
    for (const char separator : {'\t', ';', '|', ','}) {
      if (rows_.front().find(separator) != std::string_view::npos) return separator;
    }
    return ' ';
  }

  /// Commas may separate, or stand within numbers; where they do both, nobody can tell.
  Status check_commas() const {
    if (form_.separator != ',' || form_.quotes || form_.decimal_comma || roles_ ||
        options_.separator != Separator::guessed)
      return Done{};
    bool fraction = false;
    for (const std::string_view row : rows_) {
      const Cells cells = cells_of(row, ',');
      if (cells.size() < 6 || cells.size() % 2 != 0 || !std::ranges::all_of(cells, is_whole)) return Done{};
      for (std::size_t i = 1; i < cells.size(); i += 2) {
        if (!is_digit(cells[i].front())) return Done{};
        fraction |= cells[i].size() > 1 && cells[i].front() == '0';
      }
    }
    if (!fraction) return Done{};
    return error(ErrorCode::malformed_input,
                 "its commas separate values and seem to be decimal commas as well: " + in_quotes(rows_.front()) +
                     "; write it with semicolons or tabs between the values, or with "
                     "decimal points (separator=comma takes every comma as a separator)");
  }

  // Step 3: what the columns are. Reads all of the above; writes form_.roles, names, strict, by_values.
  Status tell_columns() {
    const std::size_t columns = rows_.empty() ? 0 : columns_of_first_row();
    if (roles_) return take_named(columns);
    if (header_) return take_header_roles(columns);
    std::vector<ColumnValues> values = values_of(columns);
    form_.roles = roles_by_values(values);
    if (std::ranges::find(form_.roles, Role::x) == form_.roles.end()) {
      // The first row decides, so that a later one that breaks the table is named where it is read.
      const Cells cells = cells_of(rows_.front(), form_.separator);
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
    const std::size_t columns = cells_of(rows_.front(), form_.separator).size();
    const bool open = form_.separator != ' ' && rows_.front().ends_with(form_.separator);
    return open && header_ && cells_of(*header_, form_.separator).size() == columns + 1 ? columns + 1 : columns;
  }

  Status take_named(std::size_t columns) {
    form_.roles = *roles_;
    form_.guessed = false;
    if (header_) take_names(cells_of(*header_, form_.separator), columns);
    if (columns >= roles_->size() || rows_.empty()) {
      form_.roles.resize(std::max(columns, roles_->size()), Role::none);
      return Done{};
    }
    return with_fault(
        error(ErrorCode::invalid_parameter, "columns=" + options_.columns + " names " + std::to_string(roles_->size()) +
                                                " columns; the first row has " + std::to_string(columns) + ": " +
                                                in_quotes(rows_.front())),
        {"columns", options_.columns, "as many names as there are columns, or fewer"});
  }

  /// The header's cells as the rows have them: names may hold blanks, rows may begin with a name of their own.
  Status take_header_roles(std::size_t columns) {
    const std::string text = without_units(*header_);
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
    if (names.size() + 1 == columns && !rows_.empty()) {
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
    if (rows_.empty() || form_.roles.size() == columns) return Done{};
    std::size_t known = 0;
    while (known < form_.roles.size() && form_.roles[known] != Role::none) ++known;
    form_.guessed = true;
    if (known >= 3 && known <= columns) {
      form_.roles.resize(known);
      form_.roles.resize(columns, Role::none);
      return Done{};
    }
    return error(ErrorCode::malformed_input, "its header names " + std::to_string(form_.roles.size()) +
                                                 " columns, its first row has " + std::to_string(columns) + ": " +
                                                 in_quotes(*header_) + ", " + in_quotes(rows_.front()) +
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
                                                   in_quotes(rows_.front()));
  }

  /// A line of as many words as there are columns, just before them, is a header that nobody understands.
  Status check_passed_over(std::size_t columns) const {
    if (last_passed_.empty()) return Done{};
    const Cells cells = cells_of(last_passed_, form_.separator);
    if (cells.size() != columns || count_values(cells, true) > 0) return Done{};
    std::string found;
    for (const std::string_view cell : cells) found += (found.empty() ? "" : ", ") + in_quotes(cell);
    return error(
        ErrorCode::missing_positions,
        "no columns x, y, z; found: " + found + "; columns=x,y,z, with - for a column to leave, says which they are");
  }

  /// Whether rows have text behind as many columns as the first has.
  bool has_words_behind(std::size_t columns) const {
    return std::ranges::any_of(rows_, [&](std::string_view row) {
      const Cells cells = cells_of(row, form_.separator);
      return cells.size() > columns && !is_value(cells[columns], form_.decimal_comma);
    });
  }

  std::vector<ColumnValues> values_of(std::size_t columns) const {
    std::vector<ColumnValues> values(columns);
    for (const std::string_view row : rows_) {
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
  std::optional<std::string> header_;
  std::optional<char> hinted_;
  std::size_t tries_ = 0;
  std::string last_passed_;
  std::vector<std::string_view> rows_;
  TableForm form_;
};

}  // namespace

bool is_comment(std::string_view line) {
  // #N/A is what spreadsheets write for no value.
  return (line.starts_with('#') && !in_lower_case(line.substr(0, 4)).starts_with("#n/a")) || line.starts_with("//");
}

std::string_view without_mark(std::string_view line) {
  line.remove_prefix(line.starts_with("//") ? 2 : 1);
  return trimmed(line);
}

Result<TableForm> guess_table(std::string_view sample, bool whole, std::string_view name, const TableOptions& options) {
  return Guesser(name, options).run(lines_of(sample, whole));
}

}  // namespace surfaced::io
