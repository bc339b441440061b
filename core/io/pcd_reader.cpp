// SPDX-License-Identifier: GPL-3.0-or-later
// PCD 0.5 to 0.7 (Point Cloud Library): ascii, binary, binary_compressed. Fields become the properties of a PLY
// element, so that both formats share the way of vertices into a cloud.
#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/text.hpp"
#include "io/formats.hpp"
#include "io/lzf.hpp"
#include "io/ply_ascii.hpp"
#include "io/ply_vertices.hpp"
#include "io/scalars.hpp"
#include "io/text.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

constexpr std::size_t kMostProperties = 4096;
/// Points taken apart or put together at once.
constexpr std::size_t kRowsAtOnce = 1024;
/// What decompressing may take: this much, and this much for every byte of the file.
constexpr std::uint64_t kMostUnpacked = std::uint64_t{64} << 20;
constexpr std::uint64_t kUnpackedPerByte = 16;

enum class Data : std::uint8_t { ascii, binary, compressed };

struct Field {
  std::string name;
  std::size_t size = 4;
  char type = 'F';
  std::size_t count = 1;

  std::size_t bytes() const { return size * count; }
  bool is_color() const { return (name == "rgb" || name == "rgba") && bytes() == 4 && count == 1; }
};

struct PcdHeader {
  std::vector<Field> fields;
  std::uint64_t points = 0;
  Data data{};
  /// Of the sensor, where the file tells.
  std::optional<Point3> viewpoint;

  std::size_t stride() const {
    std::size_t sum = 0;
    for (const Field& field : fields) sum += field.bytes();
    return sum;
  }
};

class HeaderReader {
 public:
  HeaderReader(ByteSource& source, std::string_view name) : name_(name), lines_(source, name) {}

  Result<PcdHeader> run() {
    for (;;) {
      const Result<bool> there = lines_.next();
      if (!there) return there.error();
      if (!*there)
        return Error{ErrorCode::truncated_input, std::string(name_) + ": the PCD header ends without a line DATA"};
      std::string_view rest = lines_.text();
      if (rest.empty() || rest.starts_with('#')) continue;
      const std::string keyword = in_lower_case(take_word(rest).substr(0, 16));
      if (keyword == "data") return finish(in_lower_case(trimmed(rest).substr(0, 32)));
      if (Status status = read(keyword, rest); !status) return std::move(status).error();
    }
  }

 private:
  Status read(const std::string& keyword, std::string_view rest) {
    if (keyword == "version") return Done{};
    if (keyword == "viewpoint") return read_viewpoint(rest);
    if (keyword == "fields" || keyword == "columns") return read_fields(rest);
    if (keyword == "size")
      return for_each_field(rest, [](Field& field, double value) {
        field.size = static_cast<std::size_t>(value);
        return value == 1 || value == 2 || value == 4 || value == 8;
      });
    if (keyword == "count")
      return for_each_field(rest, [](Field& field, double value) {
        field.count = static_cast<std::size_t>(value);
        return value >= 0 && value <= static_cast<double>(kMostProperties);
      });
    if (keyword == "type") return read_types(rest);
    if (keyword != "width" && keyword != "height" && keyword != "points") {
      return lines_.malformed(in_quotes(keyword) + " is no word of a PCD header");
    }
    double value = 0;
    if (!parse_number(trimmed(rest), Scalar::float64, value) || !(value >= 0 && value < 9e15) ||
        value != std::floor(value)) {
      return lines_.malformed(keyword + " is " + in_quotes(rest));
    }
    sizes_[keyword] = value;
    return Done{};
  }

  Status read_fields(std::string_view rest) {
    header_.fields.clear();
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
      header_.fields.push_back({.name = in_lower_case(word)});
    }
    return Done{};
  }

  /// Its translation; the rotation behind it is not needed.
  Status read_viewpoint(std::string_view rest) {
    Point3 place{};
    for (double& x : place) {
      const std::string_view word = take_word(rest);
      if (!parse_number(word, Scalar::float64, x) || !std::isfinite(x)) {
        return lines_.malformed(in_quotes(word) + " in VIEWPOINT is no coordinate");
      }
    }
    header_.viewpoint = place;
    return Done{};
  }

  template <class Set>
  Status for_each_field(std::string_view rest, Set set) {
    for (Field& field : header_.fields) {
      const std::string_view word = take_word(rest);
      double value = 0;
      if (!parse_number(word, Scalar::uint32, value) || !set(field, value)) {
        return lines_.malformed(in_quotes(word) + " for field " + in_quotes(field.name));
      }
    }
    return Done{};
  }

  Status read_types(std::string_view rest) {
    for (Field& field : header_.fields) {
      const std::string_view word = take_word(rest);
      if (word != "F" && word != "U" && word != "I") {
        return lines_.malformed("type " + in_quotes(word) + " of field " + in_quotes(field.name) +
                                "; there are I, U, F");
      }
      field.type = word.front();
    }
    return Done{};
  }

  Result<PcdHeader> finish(const std::string& data) {
    // Everybody writes 0 0 0; only images of a depth camera, which have rows, were seen from there.
    const bool image = sizes_.contains("height") && sizes_.at("height") > 1;
    if (header_.viewpoint == Point3{} && !image) header_.viewpoint.reset();
    header_.data = data == "ascii" ? Data::ascii : data == "binary" ? Data::binary : Data::compressed;
    if (header_.data == Data::compressed && data != "binary_compressed") {
      return lines_.malformed("data are " + in_quotes(data) + "; there are ascii, binary, binary_compressed");
    }
    std::size_t properties = 0;
    for (const Field& field : header_.fields) {
      properties += field.is_color() ? 4 : field.count;
      if (field.type == 'F' && field.size < 4)
        return lines_.malformed("field " + in_quotes(field.name) + " is a float of " + std::to_string(field.size) +
                                " bytes");
    }
    if (properties > kMostProperties) {
      return lines_.error(
          ErrorCode::unsupported_feature,
          std::to_string(properties) + " values a point; the limit is " + std::to_string(kMostProperties));
    }
    const double area =
        sizes_.contains("width") ? sizes_["width"] * (sizes_.contains("height") ? sizes_["height"] : 1) : 0;
    const double points = sizes_.contains("points") ? sizes_["points"] : area;
    if (points >= 1.8e19) return lines_.malformed("width times height is beyond 2^64");
    header_.points = static_cast<std::uint64_t>(points);
    return std::move(header_);
  }

  std::string_view name_;
  TextLines lines_;
  std::map<std::string, double> sizes_;
  PcdHeader header_;
};

Scalar scalar_of(const Field& field) {
  if (field.type == 'F') return field.size == 4 ? Scalar::float32 : Scalar::float64;
  const bool is_signed = field.type == 'I';
  if (field.size == 1) return is_signed ? Scalar::int8 : Scalar::uint8;
  if (field.size == 2) return is_signed ? Scalar::int16 : Scalar::uint16;
  return is_signed ? Scalar::int32 : Scalar::uint32;
}

bool is_axis(const std::string& field) { return field.ends_with('x') || field.ends_with('y') || field.ends_with('z'); }

/// The fields under the names that PLY has for them; packed colours as four bytes. Those of 64-bit integers stay
/// nameless.
PlyElement element_of(const PcdHeader& header) {
  static const std::map<std::string, std::string> kNames{
      {"x", "x"},         {"y", "y"},   {"z", "z"},     {"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"},
      {"nx", "nx"},       {"ny", "ny"}, {"nz", "nz"},   {"red", "red"},     {"green", "green"}, {"blue", "blue"},
      {"alpha", "alpha"}, {"r", "red"}, {"g", "green"}, {"b", "blue"},      {"a", "alpha"}};
  const bool packed = std::ranges::any_of(header.fields, &Field::is_color);
  PlyElement element{.name = "vertex", .count = header.points, .properties = {}};
  for (const Field& field : header.fields) {
    if (field.is_color()) {
      for (const char* name : {"blue", "green", "red", field.name == "rgba" ? "alpha" : ""}) {
        element.properties.push_back({.name = name, .type = Scalar::uint8, .count_type = {}});
      }
      continue;
    }
    const bool wide_integer = field.size == 8 && field.type != 'F';
    // Where colours are packed, fields beside them that are called like channels are none.
    const auto known = packed && !is_axis(field.name) ? kNames.end() : kNames.find(field.name);
    const std::string name = known == kNames.end() || field.count != 1 || wide_integer ? std::string() : known->second;
    const Scalar type = wide_integer ? Scalar::float64 : scalar_of(field);
    element.properties.insert(element.properties.end(), field.count, {.name = name, .type = type, .count_type = {}});
  }
  return element;
}

class PcdReader {
 public:
  PcdReader(ByteSource& source, std::string_view name, const PcdHeader& header, VertexSink sink)
      : source_(source), name_(name), header_(header), sink_(std::move(sink)) {}

  Result<RawCloud> run() {
    Status status = header_.data == Data::ascii    ? read_ascii()
                    : header_.data == Data::binary ? read_binary()
                                                   : read_compressed();
    if (!status) return source_.failure() ? *source_.failure() : std::move(status).error();
    Result<RawCloud> cloud = sink_.finish();
    if (cloud) cloud->source.viewpoint = header_.viewpoint;
    return cloud;
  }

 private:
  Error error(ErrorCode code, const std::string& what) const { return {code, std::string(name_) + ": " + what}; }
  Error truncated(std::uint64_t there) const {
    return error(ErrorCode::truncated_input, "the PCD declares " + std::to_string(header_.points) + " points, " +
                                                 std::to_string(there) + " are there");
  }

  Status read_binary() {
    const std::size_t stride = header_.stride();
    if (header_.points > source_.remaining() / stride) return truncated(source_.remaining() / stride);
    sink_.reserve(static_cast<std::size_t>(header_.points));
    for (std::uint64_t done = 0; done < header_.points;) {
      const std::span<const std::byte> window = source_.peek(stride);
      const auto count = static_cast<std::size_t>(
          std::min<std::uint64_t>(std::min(window.size() / stride, kRowsAtOnce), header_.points - done));
      if (count == 0) return truncated(done);
      sink_.push_rows(window.data(), stride, count, std::endian::native == std::endian::big);
      source_.advance(count * stride);
      done += count;
    }
    return Done{};
  }

  /// Field after field, all points of one before the next.
  Status read_compressed() {
    const std::span<const std::byte> sizes = source_.peek(8);
    if (sizes.size() < 8) return truncated(0);
    const auto packed = load_little<std::uint32_t>(sizes.data());
    const auto unpacked = load_little<std::uint32_t>(sizes.data() + 4);
    source_.advance(8);
    const std::size_t stride = header_.stride();
    if (packed > source_.remaining()) {
      return error(ErrorCode::truncated_input, std::to_string(packed) + " bytes of compressed points are declared, " +
                                                   std::to_string(source_.remaining()) + " are there");
    }
    if (header_.points > unpacked / stride || header_.points * stride != unpacked) {
      return error(ErrorCode::malformed_input, std::to_string(header_.points) + " points of " + std::to_string(stride) +
                                                   " bytes do not take " + std::to_string(unpacked) + " bytes");
    }
    const std::uint64_t need = unpacked + header_.points * sizeof(Point3);
    const std::uint64_t limit = kMostUnpacked + kUnpackedPerByte * packed;
    if (need > limit) {
      return error(ErrorCode::unsupported_feature, std::to_string(packed) + " compressed bytes would take " +
                                                       std::to_string(need) + "; the limit for so few is " +
                                                       std::to_string(limit));
    }
    std::vector<std::byte> columns(unpacked);
    const auto written = lzf_decompress(source_.peek(packed).first(packed), columns);
    if (written != columns.size()) return error(ErrorCode::malformed_input, "the compressed points are damaged");
    push_columns(columns);
    return Done{};
  }

  void push_columns(const std::vector<std::byte>& columns) {
    const std::size_t stride = header_.stride();
    const auto points = static_cast<std::size_t>(header_.points);
    sink_.reserve(points);
    std::vector<std::byte> rows(kRowsAtOnce * stride);
    for (std::size_t first = 0; first < points; first += kRowsAtOnce) {
      const std::size_t count = std::min(kRowsAtOnce, points - first);
      std::size_t offset = 0;
      for (const Field& field : header_.fields) {
        const std::size_t size = field.bytes();
        const std::byte* from = columns.data() + offset * points + first * size;
        for (std::size_t i = 0; i < count; ++i) std::copy_n(from + i * size, size, rows.data() + i * stride + offset);
        offset += size;
      }
      sink_.push_rows(rows.data(), stride, count, std::endian::native == std::endian::big);
    }
  }

  Status read_ascii() {
    TextLines lines(source_, name_);
    std::uint64_t done = 0;
    while (done < header_.points) {
      const Result<bool> there = lines.next();
      if (!there) return there.error();
      if (!*there) return truncated(done);
      if (lines.text().empty()) continue;
      VertexRow row{};
      if (Status status = read_line(lines, done, row); !status) return status;
      sink_.push(row);
      ++done;
    }
    return Done{};
  }

  Status read_line(const TextLines& lines, std::uint64_t point, VertexRow& row) const {
    std::string_view rest = lines.text();
    std::size_t property = 0;
    const auto malformed = [&](const std::string& what) {
      return error(ErrorCode::malformed_input,
                   "point " + std::to_string(point) + " of " + std::to_string(header_.points) + ": " + what);
    };
    for (const Field& field : header_.fields) {
      for (std::size_t k = 0; k < field.count; ++k) {
        const std::string_view word = take_word(rest);
        if (word.empty()) return malformed("the line ends before field " + in_quotes(field.name));
        if (field.is_color()) {
          if (!read_color(word, field, row)) return malformed(in_quotes(word) + " is no colour");
          property += 4;
          continue;
        }
        const Slot slot = sink_.layout().slots()[property++];
        if (slot == Slot::none) continue;
        if (!parse_number(word, scalar_of(field), row.at(static_cast<std::size_t>(slot)))) {
          return malformed("field " + in_quotes(field.name) + ": " + in_quotes(word) + " is no number of its type");
        }
      }
    }
    return trimmed(rest).empty() ? Status(Done{}) : Status(malformed("more values than fields"));
  }

  /// Blue, green, red, opacity in the bytes of an integer, which may be printed as the float of the same bits.
  static bool read_color(std::string_view word, const Field& field, VertexRow& row) {
    double value = 0;
    if (!parse_number(word, field.type == 'F' ? Scalar::float32 : scalar_of(field), value)) return false;
    const std::uint32_t bits = field.type == 'F' ? std::bit_cast<std::uint32_t>(static_cast<float>(value))
                                                 : static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
    const auto set = [&](Slot slot, unsigned shift) {
      row.at(static_cast<std::size_t>(slot)) = static_cast<double>(bits >> shift & 255U);
    };
    set(Slot::blue, 0);
    set(Slot::green, 8);
    set(Slot::red, 16);
    set(Slot::alpha, 24);
    return true;
  }

  ByteSource& source_;
  std::string_view name_;
  const PcdHeader& header_;
  VertexSink sink_;
};

}  // namespace

Result<RawCloud> read_pcd_cloud(ByteSource& source, std::string_view name, const ReadLimits& limits) {
  const Result<PcdHeader> header = HeaderReader(source, name).run();
  if (!header) return header.error();
  const PlyElement element = element_of(*header);
  Result<VertexLayout> layout = VertexLayout::of(element, name);
  if (!layout) return std::move(layout).error();
  const std::string called(name);
  if (header->points == 0) return Error{ErrorCode::empty_input, called + ": the PCD declares 0 points"};
  if (header->points > most_points(limits)) return too_many(name, header->points, most_points(limits));
  // The least row of an ascii file: a character and a separator a value.
  std::uint64_t values = 0;
  for (const Field& field : header->fields) values += field.count;
  const std::uint64_t least = header->data == Data::ascii    ? 2 * values
                              : header->data == Data::binary ? header->stride()
                                                             : 0;
  if (least > 0 && header->points > (source.remaining() + 1) / least) {
    return Error{ErrorCode::truncated_input, called + ": the PCD declares " + std::to_string(header->points) +
                                                 " points; the " + std::to_string(source.remaining()) +
                                                 " bytes that follow hold at most " +
                                                 std::to_string((source.remaining() + 1) / least)};
  }
  return PcdReader(source, name, *header, VertexSink(element, std::move(*layout))).run();
}

bool looks_like_pcd(std::string_view start) {
  while (!start.empty()) {
    const std::size_t end = start.find_first_of("\r\n");
    std::string_view line = trimmed(start.substr(0, end));
    start.remove_prefix(std::min(end, start.size() - 1) + 1);
    if (line.starts_with("# .PCD")) return true;
    if (line.empty() || line.starts_with('#')) continue;
    const std::string keyword = in_lower_case(take_word(line).substr(0, 16));
    return keyword == "fields" || (keyword == "version" && trimmed(line).find('.') != std::string_view::npos);
  }
  return false;
}

}  // namespace surfaced::io
