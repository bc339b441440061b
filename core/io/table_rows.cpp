// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/table_rows.hpp"

#include <algorithm>
#include <utility>

#include "base/text.hpp"
#include "io/table_guess.hpp"
#include "io/table_names.hpp"
#include "io/table_numbers.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

/// Lines of text that may stand before a table, and between its header and its rows.
constexpr std::size_t kMostPreamble = 20;
constexpr std::size_t kMostBehindHeader = 3;
/// Lines with which a row of words and numbers is compared.
constexpr std::size_t kCompared = 10;

/// A row as one separator splits it: how many cells, and which are the first three that hold values.
struct Shape {
  std::size_t cells = 0;
  std::size_t values = 0;
  std::array<std::size_t, 3> first{};
};

Shape shape_of(std::string_view line, char separator) {
  const Cells cells = cells_of(line, separator);
  Shape shape{.cells = cells.size()};
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (!is_value(cells[c], true)) continue;
    if (shape.values < 3) shape.first.at(shape.values) = c;
    ++shape.values;
  }
  return shape;
}

bool are_alike(const Shape& a, const Shape& b) {
  return a.values >= 3 && b.values >= 3 && (a.cells == b.cells || a.first == b.first);
}

class TableFinder {
 public:
  TableFinder(const std::vector<std::string_view>& lines, const TableOptions& options)
      : lines_(lines), options_(options) {}

  Result<TableStart> run() {
    const std::size_t at = find_first_row();
    for (std::size_t i = at; i < lines_.size() && found_.rows.size() < kTableRows; ++i) {
      if (is_content(lines_[i])) found_.rows.push_back(lines_[i]);
    }
    if (found_.rows.empty() && (!found_.header || behind_header_ > kMostBehindHeader)) {
      return Error{ErrorCode::unknown_format, "no line of it holds three numbers"};
    }
    if (options_.columns.empty() && is_prose()) {
      return Error{ErrorCode::unknown_format,
                   "of its lines from line " + std::to_string(at + 1) + " on, fewer than half hold three numbers"};
    }
    return std::move(found_);
  }

 private:
  /// Reads the lines; writes all of found_ but its rows.
  std::size_t find_first_row() {
    found_.skip = options_.skip;
    std::size_t preamble = 0;
    std::size_t at = std::min(options_.skip, lines_.size());
    for (; at < lines_.size() && preamble <= kMostPreamble; ++at) {
      const std::string_view line = trimmed(lines_[at]);
      if (line.empty() || is_whole(line)) continue;  // a number alone is a count of points
      const bool comment = is_comment(line);
      const bool blank = is_empty_row(lines_[at]);
      if (blank && !found_.header) continue;
      if (blank || (!comment && looks_like_row(line) && begins_table(at))) break;
      const bool known = (!comment && take_hint(line)) || take_header(comment ? without_mark(line) : lines_[at]);
      if (known || !comment) found_.skip = at + 1;
      if (known || comment) continue;
      pass_over(line);
      ++preamble;
    }
    return preamble > kMostPreamble ? lines_.size() : at;
  }

  static bool is_content(std::string_view raw) {
    const std::string_view line = trimmed(raw);
    return !line.empty() && !is_comment(line) && !is_whole(line);
  }

  bool is_empty_row(std::string_view line) const {
    return std::ranges::any_of(kSeparators, [&](char s) { return io::is_empty_row(line, s); });
  }

  bool take_hint(std::string_view line) {
    if (line.size() != 5 || in_lower_case(line.substr(0, 4)) != "sep=") return false;
    found_.hinted = line[4];
    return true;
  }

  std::vector<char> separators() const {
    if (options_.separator != Separator::guessed) return {char_of(options_.separator)};
    return {kSeparators.begin(), kSeparators.end()};
  }

  /// Three numbers, whatever separates them; perhaps text beside them. Behind a header one is enough: values may miss.
  bool looks_like_row(std::string_view line) const {
    const std::size_t least = found_.header ? 1 : 3;
    return std::ranges::any_of(separators(), [&](char s) {
      const Cells cells = cells_of(line, s);
      const std::size_t values = count_values(cells, true);
      return values >= least || (values > 0 && is_sparse(cells, s));
    });
  }

  /// No word beside its values, whose places are there: 17,,,
  static bool is_sparse(const Cells& cells, char separator) {
    return separator != ' ' && cells.size() >= 3 &&
           std::ranges::all_of(cells, [](std::string_view cell) { return cell.empty() || is_value(cell, true); });
  }

  /// Words may stand beside the numbers of a row if they do so in most of the next lines: 'Version 3, 29 June 2007' is
  /// a row of no table.
  bool begins_table(std::size_t at) const {
    if (found_.header) return true;
    std::vector<std::string_view> next;
    for (std::size_t i = at + 1; i < lines_.size() && next.size() < kCompared; ++i) {
      if (is_content(lines_[i])) next.push_back(lines_[i]);
    }
    if (!next.empty() && names_columns(next.front())) return false;
    return std::ranges::any_of(separators(), [&](char s) {
      const Shape shape = shape_of(lines_[at], s);
      if (is_sparse(cells_of(lines_[at], s), s)) return true;
      if (shape.values < 3) return false;
      // A last line of words and numbers behind others is prose.
      if (next.empty() && shape.values < shape.cells) return found_.first_passed.empty();
      const auto alike = static_cast<std::size_t>(
          std::ranges::count_if(next, [&](std::string_view line) { return are_alike(shape, shape_of(line, s)); }));
      return shape.values == shape.cells || 2 * alike >= next.size();
    });
  }

  /// Whether the line names x, y and z, whatever separates the names.
  bool take_header(std::string_view line) {
    constexpr std::size_t kMostTries = 100;
    if (found_.header || ++tries_ > kMostTries || !names_columns(line)) return false;
    found_.header = std::string(line);
    return true;
  }

  static bool names_columns(std::string_view line) {
    if (line.size() < 5) return false;
    const std::string text = without_units(line);
    return std::ranges::any_of(kSeparators, [&](char separator) {
      const HeaderMeaning meaning = meaning_of(cells_of(text, separator));
      return meaning.has_position || meaning.degrees;
    });
  }

  void pass_over(std::string_view line) {
    if (found_.first_passed.empty()) found_.first_passed = line;
    found_.last_passed = line;
    if (found_.header) ++behind_header_;
  }

  /// Whether less than half of the rows are some. A few broken rows are named where they are read.
  bool is_prose() const {
    const auto rows = static_cast<std::size_t>(std::ranges::count_if(
        found_.rows, [&](std::string_view row) { return looks_like_row(row) || is_empty_row(row); }));
    return 2 * rows < found_.rows.size();
  }

  const std::vector<std::string_view>& lines_;
  const TableOptions& options_;
  TableStart found_;
  std::size_t tries_ = 0;
  std::size_t behind_header_ = 0;
};

}  // namespace

Cells cells_of(std::string_view line, char separator) {
  Columns columns;
  columns.split(line, separator, true);
  Cells cells;
  for (std::size_t i = 0; i < std::min(columns.count(), Columns::kMost); ++i) cells.push_back(columns[i]);
  return cells;
}

std::size_t count_values(const Cells& cells, bool decimal_comma) {
  return static_cast<std::size_t>(
      std::ranges::count_if(cells, [&](auto cell) { return is_value(cell, decimal_comma); }));
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

bool is_comment(std::string_view line) {
  // #N/A is what spreadsheets write for no value.
  return (line.starts_with('#') && !in_lower_case(line.substr(0, 4)).starts_with("#n/a")) || line.starts_with("//");
}

std::string_view without_mark(std::string_view line) {
  line.remove_prefix(line.starts_with("//") ? 2 : 1);
  return trimmed(line);
}

Result<TableStart> find_table(const std::vector<std::string_view>& lines, const TableOptions& options) {
  return TableFinder(lines, options).run();
}

}  // namespace surfaced::io
