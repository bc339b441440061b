// SPDX-License-Identifier: GPL-3.0-or-later
// Points as text: XYZ, CSV and its like with a header or without, PTS with its count.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "io/colors.hpp"
#include "io/formats.hpp"
#include "io/ply_ascii.hpp"
#include "io/text.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

/// "0 0 0" and a line end.
constexpr std::uint64_t kLeastRow = 6;
/// How far from 1 the length of what counts as a normal may be: files round to as little as two digits.
constexpr double kNormalSlack = 0.1;

using Three = std::array<std::size_t, 3>;

/// Columns of a group of three values, and what was read of them.
struct Group {
  Three columns{};
  std::vector<std::array<float, 3>> values;
};

/// Where things stand in a row. Without a header the groups after the position are told by their values.
struct RowLayout {
  std::size_t columns = 0;
  Three position{0, 1, 2};
  std::optional<Group> normals;
  std::optional<Group> colors;
  std::vector<Group> unnamed;
  bool ignores_some = false;
};

std::optional<Three> find_three(const std::vector<std::string>& names, const std::array<const char*, 3>& wanted) {
  Three found{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = std::ranges::find(names, wanted.at(i));
    if (at == names.end()) return std::nullopt;
    found.at(i) = static_cast<std::size_t>(at - names.begin());
  }
  return found;
}

/// A header that names x, y and z, in any order and case.
std::optional<RowLayout> layout_of_header(const Columns& columns) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(columns.count(), Columns::kMost); ++i)
    names.push_back(in_lower_case(columns[i]));
  const auto position = find_three(names, {"x", "y", "z"});
  if (!position) return std::nullopt;
  RowLayout layout{.columns = columns.count(), .position = *position, .normals = {}, .colors = {}, .unnamed = {}};
  for (const auto& names_of_normals : {std::array{"nx", "ny", "nz"}, std::array{"normal_x", "normal_y", "normal_z"}}) {
    const auto found = find_three(names, names_of_normals);
    if (found && !layout.normals) layout.normals = Group{*found, {}};
  }
  for (const auto& names_of_colors : {std::array{"r", "g", "b"}, std::array{"red", "green", "blue"}}) {
    const auto found = find_three(names, names_of_colors);
    if (found && !layout.colors) layout.colors = Group{*found, {}};
  }
  layout.ignores_some = layout.columns > 3U + (layout.normals ? 3U : 0U) + (layout.colors ? 3U : 0U);
  return layout;
}

/// x y z, then groups of three, before them an intensity if one column is left over.
RowLayout layout_of_numbers(std::size_t columns) {
  RowLayout layout{.columns = columns, .position = {0, 1, 2}, .normals = {}, .colors = {}, .unnamed = {}};
  const std::size_t rest = columns - 3;
  const std::size_t first = rest % 3 == 1 ? 4 : 3;
  if (rest % 3 != 2) {
    for (std::size_t c = first; c + 3 <= std::min(columns, Columns::kMost) && layout.unnamed.size() < 2; c += 3) {
      layout.unnamed.push_back({{c, c + 1, c + 2}, {}});
    }
  }
  layout.ignores_some = columns > 3 + 3 * layout.unnamed.size();
  return layout;
}

bool are_normals(const Group& group) {
  return std::ranges::all_of(group.values, [](const std::array<float, 3>& v) {
    return std::abs(std::hypot(v[0], v[1], v[2]) - 1) <= kNormalSlack;
  });
}

bool are_colors(const Group& group) {
  return std::ranges::all_of(group.values, [](const std::array<float, 3>& v) {
    return std::ranges::all_of(v, [](float x) { return x >= 0 && x <= 255 && x == std::floor(x); });
  });
}

bool is_comment(std::string_view line) { return line.starts_with('#') || line.starts_with("//"); }

char separator_of(std::string_view line) {
  for (const char c : {';', ','}) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return ' ';
}

class TextReader {
 public:
  TextReader(ByteSource& source, std::string_view name, const ReadLimits& limits)
      : source_(source), name_(name), lines_(source, name), most_(most_points(limits)) {}

  Result<RawCloud> run() {
    for (;;) {
      const Result<bool> there = lines_.next();
      if (!there) return there.error();
      if (!*there) break;
      const std::string_view line = lines_.text();
      if (line.empty()) continue;
      Status status = is_comment(line) ? read_comment(line) : layout_ ? read_row(line) : read_first(line);
      if (!status) return std::move(status).error();
    }
    if (declared_ && cloud_.size() < *declared_) {
      return Error{ErrorCode::truncated_input, std::string(name_) + ": the file ends after " +
                                                   std::to_string(cloud_.size()) + " of " + std::to_string(*declared_) +
                                                   " points"};
    }
    if (cloud_.size() == 0) return Error{ErrorCode::empty_input, std::string(name_) + ": the text holds no points"};
    finish();
    return std::move(cloud_);
  }

 private:
  /// CloudCompare and others write the header as a comment.
  Status read_comment(std::string_view line) {
    if (layout_) return Done{};
    line.remove_prefix(line.starts_with("//") ? 2 : 1);
    separator_ = separator_of(line);
    columns_.split(trimmed(line), separator_);
    set_layout(layout_of_header(columns_));
    from_comment_ = layout_.has_value();
    return Done{};
  }

  Status read_first(std::string_view line) {
    separator_ = separator_of(line);
    columns_.split(line, separator_);
    if (columns_.count() == 1 && !declared_) return read_count();
    if (columns_.count() == 1) {
      return lines_.error(ErrorCode::unsupported_feature,
                          "a second number alone, as in PTX scans; convert the file to PTS or PLY");
    }
    double ignored = 0;
    if (!number(columns_[0], ignored)) {
      set_layout(layout_of_header(columns_));
      if (layout_) return Done{};
      return lines_.malformed(in_quotes(line) + " is neither three numbers nor a header with x, y and z");
    }
    if (columns_.count() < 3) {
      return lines_.malformed(std::to_string(columns_.count()) + " values; a point needs 3");
    }
    set_layout(layout_of_numbers(columns_.count()));
    return read_row(line);
  }

  /// PTS: the number of points, at the beginning of every scan.
  Status read_count() {
    double count = 0;
    if (!parse_number(columns_[0], Scalar::float64, count) || !(count >= 0) || count != std::floor(count)) {
      return lines_.malformed(in_quotes(columns_[0]) + " is no number of points");
    }
    const double room = static_cast<double>((source_.remaining() + 1) / kLeastRow);
    if (count > room) {
      return lines_.error(ErrorCode::truncated_input,
                          in_quotes(columns_[0]) + " points are declared; the " + std::to_string(source_.remaining()) +
                              " bytes that follow hold at most " + std::to_string(static_cast<std::uint64_t>(room)));
    }
    declared_ = cloud_.size() + static_cast<std::uint64_t>(count);
    if (*declared_ > most_) return too_many(name_, *declared_, most_);
    return Done{};
  }

  Status read_row(std::string_view line) {
    if (from_comment_) {  // the header's own separator may differ from that of the rows
      separator_ = separator_of(line);
      from_comment_ = false;
    }
    columns_.split(line, separator_);
    if (declared_ && cloud_.size() == *declared_) {
      if (columns_.count() == 1) return read_count();
      return lines_.malformed("more points than the " + std::to_string(*declared_) + " that are declared");
    }
    if (columns_.count() != layout_->columns) {
      return lines_.malformed(std::to_string(columns_.count()) + " values; the first row has " +
                              std::to_string(layout_->columns));
    }
    if (cloud_.size() >= most_) return too_many(name_, cloud_.size() + 1, most_);
    Point3 point{};
    if (Status status = read_three(layout_->position, point); !status) return status;
    cloud_.positions.push_back(point);
    for (Group* group : groups_) {
      if (Status status = read_three(group->columns, point); !status) return status;
      group->values.push_back(
          {static_cast<float>(point[0]), static_cast<float>(point[1]), static_cast<float>(point[2])});
    }
    return Done{};
  }

  void set_layout(std::optional<RowLayout> layout) {
    layout_ = std::move(layout);
    groups_.clear();
    if (!layout_) return;
    if (layout_->normals) groups_.push_back(&*layout_->normals);
    if (layout_->colors) groups_.push_back(&*layout_->colors);
    for (Group& group : layout_->unnamed) groups_.push_back(&group);
  }

  Status read_three(const Three& columns, Point3& values) const {
    for (std::size_t i = 0; i < 3; ++i) {
      if (number(columns_[columns[i]], values[i])) continue;
      return lines_.malformed("column " + std::to_string(columns[i] + 1) + ": " + in_quotes(columns_[columns[i]]) +
                              " is no number");
    }
    return Done{};
  }

  /// Where semicolons separate, a comma is a decimal point.
  bool number(std::string_view text, double& value) const {
    const std::size_t comma = separator_ == ';' ? text.find(',') : std::string_view::npos;
    if (comma == std::string_view::npos) return parse_number(text, Scalar::float64, value);
    std::string pointed(text.substr(0, kTokenLimit));
    pointed[comma] = '.';
    return parse_number(pointed, Scalar::float64, value);
  }

  void finish() {
    for (Group& group : layout_->unnamed) {
      if (!layout_->normals && are_normals(group)) {
        layout_->normals = std::move(group);
      } else if (!layout_->colors && are_colors(group)) {
        layout_->colors = std::move(group);
      } else {
        layout_->ignores_some = true;
      }
    }
    if (layout_->ignores_some) {
      const std::size_t used = 3U + (layout_->normals ? 3U : 0U) + (layout_->colors ? 3U : 0U);
      cloud_.warnings.push_back(std::to_string(layout_->columns - used) + " of " + std::to_string(layout_->columns) +
                                " columns ignored: they are neither positions nor normals nor colours");
    }
    if (layout_->normals) cloud_.normals = std::move(layout_->normals->values);
    if (layout_->colors) {
      std::vector<WideColor> wide;
      wide.reserve(cloud_.size());
      for (const auto& c : layout_->colors->values) wide.push_back({c[0], c[1], c[2], 0});
      cloud_.colors = to_bytes(wide, !are_colors(*layout_->colors), false, cloud_.warnings);
    }
  }

  ByteSource& source_;
  std::string_view name_;
  TextLines lines_;
  std::uint64_t most_;
  Columns columns_;
  char separator_ = ' ';
  std::optional<RowLayout> layout_;
  bool from_comment_ = false;
  std::optional<std::uint64_t> declared_;
  std::vector<Group*> groups_;  // of the layout
  RawCloud cloud_;
};

}  // namespace

Result<RawCloud> read_text_cloud(ByteSource& source, std::string_view name, const ReadLimits& limits) {
  return TextReader(source, name, limits).run();
}

bool looks_like_text_cloud(std::string_view start) {
  while (!start.empty()) {
    const std::size_t end = start.find_first_of("\r\n");
    std::string_view line = trimmed(start.substr(0, end));
    start.remove_prefix(std::min(end, start.size() - 1) + 1);
    const bool comment = is_comment(line);
    if (comment) line.remove_prefix(line.starts_with("//") ? 2 : 1);
    if (line.empty()) continue;
    Columns columns;
    columns.split(trimmed(line), separator_of(line));
    if (layout_of_header(columns)) return true;
    if (comment) continue;
    double value = 0;
    // A decimal comma, where semicolons separate, may stand in the first number.
    std::string first(columns.count() == 0 ? std::string_view() : columns[0]);
    std::ranges::replace(first, ',', '.');
    return (columns.count() == 1 || columns.count() >= 3) && parse_number(first, Scalar::float64, value);
  }
  return false;
}

}  // namespace surfaced::io
