// SPDX-License-Identifier: GPL-3.0-or-later
// Points as text: XYZ, CSV and its like with a header or without, PTS with its count.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "io/colors.hpp"
#include "io/formats.hpp"
#include "io/ply_ascii.hpp"
#include "io/table_guess.hpp"
#include "io/table_numbers.hpp"
#include "io/table_values.hpp"
#include "io/text.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

/// "0 0 0" and a line end.
constexpr std::uint64_t kLeastRow = 6;
/// After so many rows memory is set aside for the others, if all are as long.
constexpr std::size_t kMeasuredRows = 1000;

using Three = std::array<std::size_t, 3>;

/// Columns of a group of three values, and what was read of them.
struct Group {
  Three columns{};
  std::vector<std::array<float, 3>> values;
};

/// The columns of three roles that follow one another, if they are there.
std::optional<Group> group_of(const std::vector<Role>& roles, Role first) {
  Group group;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto role = static_cast<Role>(static_cast<std::size_t>(first) + i);
    const auto found = std::ranges::find(roles, role);
    if (found == roles.end()) return std::nullopt;
    group.columns.at(i) = static_cast<std::size_t>(found - roles.begin());
  }
  return group;
}

std::string_view word_for(char separator) {
  constexpr auto kWords = std::to_array<std::pair<char, std::string_view>>(
      {{'\t', "tab"}, {',', "comma"}, {';', "semicolon"}, {'|', "bar"}});
  const auto* found = std::ranges::find(kWords, separator, [](const auto& row) { return row.first; });
  return found == kWords.end() ? "blank" : found->second;
}

std::string list_of(const std::vector<Role>& roles) {
  std::string list;
  for (const Role role : roles) list += (list.empty() ? "" : ",") + std::string(name_of(role));
  return list;
}

/// The columns that nothing is made of, by name or by number.
std::string left_columns(const TableForm& form) {
  std::string list;
  for (std::size_t c = 0; c < form.roles.size() && list.size() < 200; ++c) {
    if (form.roles[c] != Role::none) continue;
    const bool named = c < form.names.size() && !form.names[c].empty();
    list += (list.empty() ? "" : ", ") + (named ? in_quotes(form.names[c]) : "column " + std::to_string(c + 1));
  }
  return list;
}

class TextReader {
 public:
  TextReader(ByteSource& source, std::string_view name, const ReadOptions& options, TableForm form)
      : source_(source),
        bytes_(source.remaining()),
        name_(name),
        lines_(source, name),
        most_(most_points(options.limits)),
        take_truncated_(options.take_truncated),
        form_(std::move(form)),
        position_(group_of(form_.roles, Role::x)->columns),
        normals_(group_of(form_.roles, Role::nx)),
        colors_(group_of(form_.roles, Role::r)) {
    for (std::size_t c = 0; c < form_.roles.size(); ++c) {
      if (form_.roles[c] != Role::none) needed_ = c + 1;
    }
  }

  Result<RawCloud> run() {
    for (;;) {
      const Result<bool> there = lines_.next();
      if (!there) return there.error();
      if (!*there) break;
      if (lines_.number() <= form_.skip || is_comment(lines_.text())) continue;
      if (lines_.text().empty() && !(form_.separator == '\t' && is_empty_row(lines_.raw(), '\t'))) continue;
      if (Status status = read_row(); !status) return std::move(status).error();
    }
    if (Status counted = check_count(); !counted) return std::move(counted).error();
    if (cloud_.size() == 0) return Error{ErrorCode::empty_input, std::string(name_) + ": the text holds no points"};
    finish();
    return std::move(cloud_);
  }

 private:
  Status check_count() {
    if (undeclared_ > 0) {
      cloud_.warnings.push_back(std::to_string(undeclared_) + " points more than the file's counts declare; read all");
    }
    if (!declared_ || cloud_.size() >= *declared_) return Done{};
    const std::string what =
        "the file ends after " + std::to_string(cloud_.size()) + " of " + std::to_string(*declared_) + " points";
    if (!take_truncated_) {
      return Error{ErrorCode::truncated_input,
                   std::string(name_) + ": " + what + "; truncated=take reads what is there"};
    }
    cloud_.warnings.push_back(what);
    return Done{};
  }

  /// PTS: the number of points, at the beginning of every scan.
  Status read_count() {
    if (declared_ && cloud_.size() == 0 && *declared_ > 0) {
      return lines_.error(ErrorCode::unsupported_feature,
                          "a second number alone, as in PTX scans; convert the file to PTS or PLY");
    }
    double count = 0;
    if (!parse_number(columns_[0], Scalar::float64, count) || !(count >= 0) || count != std::floor(count)) {
      return lines_.malformed(in_quotes(columns_[0]) + " is no number of points");
    }
    const double room = static_cast<double>((source_.remaining() + 1) / kLeastRow);
    if (count > room && !take_truncated_) {
      return lines_.error(ErrorCode::truncated_input,
                          in_quotes(columns_[0]) + " points are declared; the " + std::to_string(source_.remaining()) +
                              " bytes that follow hold at most " + std::to_string(static_cast<std::uint64_t>(room)));
    }
    declared_ = cloud_.size() + static_cast<std::uint64_t>(std::min(count, room));
    if (*declared_ > most_) return too_many(name_, *declared_, most_);
    return Done{};
  }

  Status read_row() {
    columns_.split(lines_.raw(), form_.separator, form_.quotes);
    // The last value may be missing behind its separator.
    if (columns_.count() < needed_ && form_.separator != ' ' && lines_.raw().ends_with(form_.separator))
      columns_.push_missing();
    while (columns_.count() < form_.roles.size() && is_empty_row(lines_.raw(), form_.separator))
      columns_.push_missing();
    const std::size_t count = columns_.count();
    if (count == 1 && (cloud_.size() == 0 || (declared_ && cloud_.size() >= *declared_))) return read_count();
    if (form_.strict ? count != form_.roles.size() : count < needed_) {
      return lines_.malformed(std::to_string(count) + " values; " +
                              (form_.strict ? "the first row has " + std::to_string(form_.roles.size())
                                            : std::to_string(needed_) + " are needed"));
    }
    if (declared_ && cloud_.size() >= *declared_) ++undeclared_;
    if (cloud_.size() >= most_) return too_many(name_, cloud_.size() + 1, most_);
    if (cloud_.size() == kMeasuredRows) reserve();
    Point3 point{};
    if (Status status = read_three(position_, point); !status) return status;
    cloud_.positions.push_back(point);
    for (std::optional<Group>* group : {&normals_, &colors_}) {
      if (!*group) continue;
      if (Status status = read_three((*group)->columns, point); !status) return status;
      (*group)->values.push_back(
          {static_cast<float>(point[0]), static_cast<float>(point[1]), static_cast<float>(point[2])});
    }
    return Done{};
  }

  Status read_three(const Three& columns, Point3& values) const {
    for (std::size_t i = 0; i < 3; ++i) {
      if (parse_cell(columns_[columns[i]], form_.decimal_comma, values[i])) continue;
      return lines_.malformed("column " + std::to_string(columns[i] + 1) + ": " + in_quotes(columns_[columns[i]]) +
                              " is no number");
    }
    return Done{};
  }

  void reserve() {
    const std::uint64_t row = std::max((bytes_ - source_.remaining()) / lines_.number(), kLeastRow);
    const auto points = static_cast<std::size_t>(std::min(cloud_.size() + source_.remaining() / row, most_));
    cloud_.positions.reserve(points);
    for (std::optional<Group>* group : {&normals_, &colors_}) {
      if (*group) (*group)->values.reserve(points);
    }
  }

  /// Groups told by their values are those only if the rows behind the sample agree.
  void check_groups() {
    const auto all = [](const Group& group, const auto& is) {
      return std::ranges::all_of(group.values, [&](const std::array<float, 3>& v) {
        return are_missing({v[0], v[1], v[2]}) || is({v[0], v[1], v[2]});
      });
    };
    const auto drop = [&](std::optional<Group>& group, const char* what) {
      for (const std::size_t c : group->columns) form_.roles[c] = Role::none;
      cloud_.warnings.push_back("columns " + std::to_string(group->columns[0] + 1) + " to " +
                                std::to_string(group->columns[2] + 1) + " ignored: not all of them are " + what);
      group.reset();
    };
    if (normals_ && !all(*normals_, is_normal)) drop(normals_, "normals");
    if (colors_ && !all(*colors_, is_color)) drop(colors_, "colours from 0 to 255");
  }

  void finish() {
    if (form_.by_values) check_groups();
    warn();
    if (normals_) cloud_.normals = std::move(normals_->values);
    if (colors_) take_colors();
    TableFacts facts{.columns = {},
                     .separator = std::string(word_for(form_.separator)),
                     .decimal = form_.decimal_comma ? "comma" : "point",
                     .skipped = form_.skip,
                     .guessed = form_.guessed};
    for (const Role role : form_.roles) facts.columns.emplace_back(name_of(role));
    cloud_.source.table = std::move(facts);
  }

  void take_colors() {
    std::vector<WideColor> wide;
    wide.reserve(cloud_.size());
    bool whole = true;
    for (const auto& c : colors_->values) {
      // A point without a measurement has no colour either.
      const bool there = std::isfinite(c[0]) && std::isfinite(c[1]) && std::isfinite(c[2]);
      wide.push_back(there ? WideColor{c[0], c[1], c[2], 0} : WideColor{});
      whole &= !there || is_color({c[0], c[1], c[2]});
    }
    cloud_.colors = to_bytes(wide, !whole, false, cloud_.warnings);
  }

  void warn() {
    if (!form_.passed_over.empty()) {
      cloud_.warnings.push_back("lines before the table passed over, the first being " + in_quotes(form_.passed_over));
    }
    const auto left = static_cast<std::size_t>(std::ranges::count(form_.roles, Role::none));
    const std::string ignored = left == 0 ? std::string()
                                          : std::to_string(left) + " of " + std::to_string(form_.roles.size()) +
                                                " columns ignored: " + left_columns(form_);
    if (form_.guessed) {
      cloud_.warnings.push_back("columns read as " + list_of(form_.roles) +
                                (form_.decimal_comma ? " with decimal commas" : "") + ", guessed from their " +
                                (form_.by_values ? "values" : "names") + (ignored.empty() ? "" : "; " + ignored) +
                                "; columns=" + list_of(form_.roles) + (form_.decimal_comma ? " decimal=comma" : "") +
                                " says so, or otherwise");
    } else if (!ignored.empty()) {
      cloud_.warnings.push_back(ignored);
    }
  }

  ByteSource& source_;
  std::uint64_t bytes_;
  std::string_view name_;
  TextLines lines_;
  std::uint64_t most_;
  bool take_truncated_;
  TableForm form_;
  Three position_;
  std::optional<Group> normals_;
  std::optional<Group> colors_;
  /// Columns up to the last that is read.
  std::size_t needed_ = 0;
  Columns columns_;
  std::optional<std::uint64_t> declared_;
  std::uint64_t undeclared_ = 0;
  RawCloud cloud_;
};

Result<TableForm> form_of_text(ByteSource& source, std::string_view name, const TableOptions& options) {
  const std::span<const std::byte> bytes = source.peek(kTableSample);
  const std::string_view text = text_of(bytes).substr(0, kTableSample);
  return guess_table(text, source.remaining() <= text.size(), name, options);
}

}  // namespace

bool looks_like_table(ByteSource& source) {
  const Result<TableForm> form = form_of_text(source, {}, {});
  return form || form.error().code != ErrorCode::unknown_format;
}

Result<RawCloud> read_text_cloud(ByteSource& source, std::string_view name, const ReadOptions& options) {
  Result<TableForm> form = form_of_text(source, name, options.table);
  if (!form) return std::move(form).error();
  return TextReader(source, name, options, std::move(*form)).run();
}

}  // namespace surfaced::io
