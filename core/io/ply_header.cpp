// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/ply_header.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <utility>

#include "base/text.hpp"
#include "io/text.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

constexpr std::size_t kHeaderLimit = std::size_t{1} << 20;

constexpr auto kTypeNames = std::to_array<std::pair<std::string_view, Scalar>>({
    {"char", Scalar::int8},
    {"int8", Scalar::int8},
    {"uchar", Scalar::uint8},
    {"uint8", Scalar::uint8},
    {"short", Scalar::int16},
    {"int16", Scalar::int16},
    {"ushort", Scalar::uint16},
    {"uint16", Scalar::uint16},
    {"int", Scalar::int32},
    {"int32", Scalar::int32},
    {"uint", Scalar::uint32},
    {"uint32", Scalar::uint32},
    {"float", Scalar::float32},
    {"float32", Scalar::float32},
    {"double", Scalar::float64},
    {"float64", Scalar::float64},
});

constexpr auto kEncodingNames = std::to_array<std::pair<std::string_view, PlyEncoding>>({
    {"ascii", PlyEncoding::ascii},
    {"binary_little_endian", PlyEncoding::binary_little_endian},
    {"binary_big_endian", PlyEncoding::binary_big_endian},
});

template <class Table>
auto look_up(const Table& table, std::string_view name) -> std::optional<decltype(table.front().second)> {
  const auto* found = std::ranges::find(table, name, [](const auto& row) { return row.first; });
  if (found == table.end()) return std::nullopt;
  return found->second;
}

/// Takes words off a line.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}

  std::string_view next() {
    const std::size_t begin = rest_.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return rest_ = {};
    const std::size_t end = std::min(rest_.find_first_of(" \t", begin), rest_.size());
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return word;
  }

 private:
  std::string_view rest_;
};

/// Takes lines off the source, which lie in one window.
class Lines {
 public:
  explicit Lines(ByteSource& source) : source_(source) {}

  /// Next line without its end; none if the input or the room for a header ends before the line does.
  std::optional<std::string_view> next() {
    for (;;) {
      const std::string_view window = text();
      if (number_ == 0) {
        const std::size_t cr = window.find_first_of("\r\n");
        only_cr_ = cr < window.size() - 1 && window[cr] == '\r' && window[cr + 1] != '\n';
      }
      const std::size_t end = window.find(only_cr_ ? '\r' : '\n', consumed_);
      if (end != std::string_view::npos) {
        std::string_view line = window.substr(consumed_, end - consumed_);
        if (line.ends_with('\r')) line.remove_suffix(1);
        consumed_ = end + 1;
        ++number_;
        return line;
      }
      if (window.size() >= kHeaderLimit || !grow()) return std::nullopt;
    }
  }

  std::size_t number() const { return number_; }
  std::size_t consumed() const { return consumed_; }
  bool out_of_room() const { return source_.remaining() >= kHeaderLimit; }

 private:
  std::string_view text() {
    const std::span<const std::byte> bytes = source_.peek(wanted_);
    return text_of(bytes).substr(0, kHeaderLimit);
  }

  bool grow() {
    if (wanted_ >= kHeaderLimit || wanted_ >= source_.remaining()) return false;
    wanted_ *= 2;
    return true;
  }

  ByteSource& source_;
  std::size_t wanted_ = 4096;
  std::size_t consumed_ = 0;
  std::size_t number_ = 0;
  bool only_cr_ = false;
};

class HeaderParser {
 public:
  HeaderParser(ByteSource& source, std::string_view name) : source_(source), lines_(source), name_(name) {}

  Result<PlyHeader> run() {
    for (;;) {
      const std::optional<std::string_view> line = lines_.next();
      if (!line) return no_end();
      Words words(*line);
      const std::string_view keyword = words.next();
      if (lines_.number() == 1 || keyword.empty() || keyword == "comment" || keyword == "obj_info") continue;
      if (keyword == "end_header") break;
      Status status = keyword == "format"     ? format(words)
                      : keyword == "element"  ? element(words)
                      : keyword == "property" ? property(words)
                                              : malformed("unknown keyword " + in_quotes(keyword));
      if (!status) return std::move(status).error();
    }
    source_.advance(lines_.consumed());
    if (!has_format_)
      return Error{ErrorCode::malformed_input, std::string(name_) + ": the PLY header has no line 'format'"};
    if (Status unique = check_names(); !unique) return std::move(unique).error();
    if (Status counts = check_counts(); !counts) return std::move(counts).error();
    return std::move(header_);
  }

 private:
  std::string at_line() const { return std::string(name_) + ", line " + std::to_string(lines_.number()) + ": "; }
  Error malformed(const std::string& what) const { return {ErrorCode::malformed_input, at_line() + what}; }

  Error no_end() const {
    if (lines_.out_of_room()) {
      return {ErrorCode::malformed_input, std::string(name_) + ": no line 'end_header' in the first " +
                                              std::to_string(kHeaderLimit) + " bytes, the limit of a PLY header"};
    }
    return {ErrorCode::truncated_input, std::string(name_) + ": the file ends in its PLY header, after line " +
                                            std::to_string(lines_.number()) + " and " +
                                            std::to_string(source_.remaining()) + " bytes"};
  }

  Status format(Words& words) {
    const std::string_view encoding = words.next();
    const std::string_view version = words.next();
    const auto found = look_up(kEncodingNames, encoding);
    if (!found) {
      return malformed("format " + in_quotes(encoding) + " is none of ascii, binary_little_endian, binary_big_endian");
    }
    if (version != "1.0")
      return Error{ErrorCode::unsupported_feature, at_line() + "PLY version " + in_quotes(version) + "; 1.0 is read"};
    if (has_format_) return malformed("a second line 'format'");
    has_format_ = true;
    header_.encoding = *found;
    return Done{};
  }

  Status element(Words& words) {
    PlyElement element;
    element.name = words.next();
    const std::string_view count = words.next();
    const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (element.name.empty() || count.empty()) return malformed("an element needs a name and a count");
    if (error == std::errc::result_out_of_range) element.count = std::numeric_limits<std::uint64_t>::max();
    if (error == std::errc::invalid_argument || end != count.data() + count.size()) {
      return malformed("element " + in_quotes(element.name) + ": the count " + in_quotes(count) +
                       " is no whole number from 0 on");
    }
    header_.elements.push_back(std::move(element));
    return Done{};
  }

  Status property(Words& words) {
    if (header_.elements.empty()) return malformed("a property before the first element");
    PlyProperty property;
    std::string_view type = words.next();
    if (type == "list") {
      const std::string_view count_type = words.next();
      property.count_type = look_up(kTypeNames, count_type);
      if (!property.count_type) return unknown_type(count_type);
      if (*property.count_type == Scalar::float32 || *property.count_type == Scalar::float64) {
        return malformed("a list counted by " + in_quotes(count_type) + "; an integer type is needed");
      }
      type = words.next();
    }
    const auto found = look_up(kTypeNames, type);
    if (!found) return unknown_type(type);
    property.type = *found;
    property.name = words.next();
    if (property.name.empty()) return malformed("a property needs a name");
    header_.elements.back().properties.push_back(std::move(property));
    return Done{};
  }

  Error unknown_type(std::string_view type) const {
    return malformed("type " + in_quotes(type) + " is none of char, uchar, short, ushort, int, uint, float, double, " +
                     "int8, uint8, int16, uint16, int32, uint32, float32, float64");
  }

  Status check_names() const {
    std::vector<std::string_view> names;
    for (const PlyElement& element : header_.elements) names.emplace_back(element.name);
    if (const auto twice = repeated(names)) return repeated_name("element", *twice);
    for (const PlyElement& element : header_.elements) {
      names.clear();
      for (const PlyProperty& property : element.properties) names.emplace_back(property.name);
      if (const auto twice = repeated(names)) return repeated_name("property", *twice);
    }
    return Done{};
  }

  static std::optional<std::string_view> repeated(std::vector<std::string_view>& names) {
    std::ranges::sort(names);
    const auto found = std::ranges::adjacent_find(names);
    if (found == names.end()) return std::nullopt;
    return *found;
  }

  Error repeated_name(const char* kind, std::string_view name) const {
    return {ErrorCode::malformed_input,
            std::string(name_) + ": " + kind + " " + in_quotes(name) + " is declared twice"};
  }

  /// A declared count that the rest of the file cannot hold is refused before anything is allocated.
  Status check_counts() const {
    std::uint64_t left = source_.remaining();
    const bool ascii = header_.encoding == PlyEncoding::ascii;
    if (ascii) ++left;  // the separator that the last value may lack
    for (const PlyElement& element : header_.elements) {
      const std::uint64_t row = ascii ? element.least_ascii_row() : element.least_binary_row();
      if (row == 0) continue;
      if (element.count > left / row) return too_many_rows(element, row);
      left -= element.count * row;
    }
    return Done{};
  }

  Error too_many_rows(const PlyElement& element, std::uint64_t row) const {
    const bool exact = header_.encoding != PlyEncoding::ascii && !element.has_lists();
    std::string detail = std::string(name_) + ": element " + in_quotes(element.name) + " declares " +
                         std::to_string(element.count) + " rows of " + (exact ? "" : "at least ") +
                         std::to_string(row) + " bytes, but only " + std::to_string(source_.remaining()) +
                         " bytes follow the header";
    if (exact && &element == &header_.elements.front()) {
      detail += ": room for " + std::to_string(source_.remaining() / row) + " of " + std::to_string(element.count);
    }
    return {ErrorCode::truncated_input, detail};
  }

  ByteSource& source_;
  Lines lines_;
  std::string_view name_;
  PlyHeader header_;
  bool has_format_ = false;
};

}  // namespace

std::size_t size_of(Scalar type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes.at(static_cast<std::size_t>(type));
}

bool PlyElement::has_lists() const { return std::ranges::any_of(properties, &PlyProperty::is_list); }

std::optional<std::size_t> PlyElement::find(std::string_view property) const {
  auto found = std::ranges::find(properties, property, &PlyProperty::name);
  if (found == properties.end()) {
    found = std::ranges::find_if(properties, [&](const PlyProperty& p) { return in_lower_case(p.name) == property; });
  }
  if (found == properties.end()) return std::nullopt;
  return static_cast<std::size_t>(found - properties.begin());
}

std::size_t PlyElement::least_binary_row() const {
  std::size_t size = 0;
  for (const PlyProperty& property : properties) size += size_of(property.count_type.value_or(property.type));
  return size;
}

const PlyElement* PlyHeader::find(std::string_view element) const {
  const auto found = std::ranges::find(elements, element, &PlyElement::name);
  return found == elements.end() ? nullptr : &*found;
}

bool looks_like_ply(std::span<const std::byte> bytes) {
  constexpr std::string_view kMagic = "ply";
  constexpr std::size_t kLongest = 80;
  const std::string_view text = text_of(bytes).substr(0, kLongest);
  if (in_lower_case(text.substr(0, kMagic.size())) != kMagic) return false;
  const std::size_t end = text.find_first_not_of(" \t", kMagic.size());
  return end != std::string_view::npos && (text[end] == '\n' || text[end] == '\r');
}

Result<PlyHeader> read_ply_header(ByteSource& source, std::string_view name) {
  return HeaderParser(source, name).run();
}

}  // namespace surfaced::io
