// SPDX-License-Identifier: GPL-3.0-or-later
// LAS 1.2 to 1.4 (ASPRS, "LAS specification 1.4 R15", 2019): positions and colours of point records 0 to 10.
#include <algorithm>
#include <array>
#include <cmath>

#include "io/colors.hpp"
#include "io/formats.hpp"
#include "io/scalars.hpp"

namespace surfaced::io {
namespace {

constexpr std::size_t kHeader = 227;    // 1.2
constexpr std::size_t kHeader13 = 235;  // 1.3
constexpr std::size_t kHeader14 = 375;  // 1.4
/// Records converted at once.
constexpr std::size_t kRecordsAtOnce = 4096;

/// Least length of a point record by its format, and where its colour stands (0: nowhere).
struct Record {
  std::uint16_t length;
  std::uint16_t color;
};
constexpr auto kRecords = std::to_array<Record>(
    {{20, 0}, {28, 0}, {26, 20}, {34, 28}, {57, 0}, {63, 28}, {30, 0}, {36, 30}, {38, 30}, {59, 0}, {67, 30}});

/// What a header says, checked against itself and the size of the file.
struct LasHeader {
  std::uint64_t offset = 0;
  std::uint64_t count = 0;
  /// Where what follows the points begins (waveforms, extended records); 0: at the end of the file.
  std::uint64_t end = 0;
  std::size_t stride = 0;
  std::size_t color = 0;
  Point3 scale{};
  Point3 shift{};
};

class LasReader {
 public:
  LasReader(ByteSource& source, std::string_view name, const ReadOptions& options)
      : source_(source), name_(name), most_(most_points(options.limits)), take_truncated_(options.take_truncated) {}

  Result<RawCloud> run() {
    Result<LasHeader> header = read_header();
    if (!header) return std::move(header).error();
    if (Status status = check_size(*header); !status) return std::move(status).error();
    if (!source_.skip(header->offset)) return truncated("the file ends before its point records");
    return read_records(*header);
  }

 private:
  Error error(ErrorCode code, const std::string& what) const { return {code, std::string(name_) + ": " + what}; }
  Error truncated(const std::string& what) const { return error(ErrorCode::truncated_input, what); }
  Error malformed(const std::string& what) const { return error(ErrorCode::malformed_input, what); }

  Result<LasHeader> read_header() {
    const std::span<const std::byte> bytes = source_.peek(kHeader14);
    if (bytes.size() < kHeader) {
      return truncated("the LAS header takes " + std::to_string(kHeader) + " bytes, " + std::to_string(bytes.size()) +
                       " are there");
    }
    const auto major = load_little<std::uint8_t>(bytes.data() + 24);
    const auto minor = load_little<std::uint8_t>(bytes.data() + 25);
    if (major != 1 || minor > 4) {
      return error(ErrorCode::unsupported_feature,
                   "LAS version " + std::to_string(major) + "." + std::to_string(minor) + "; 1.0 to 1.4 are read");
    }
    const auto format = load_little<std::uint8_t>(bytes.data() + 104);
    if (format >= 64) {
      return error(ErrorCode::unsupported_feature,
                   "the points are compressed (LAZ, point format " + std::to_string(format) +
                       "); convert it with 'laszip -i cloud.laz -o cloud.las' or 'pdal translate cloud.laz cloud.las'");
    }
    if (format >= kRecords.size()) {
      return error(ErrorCode::unsupported_feature, "point format " + std::to_string(format) + "; 0 to 10 are read");
    }
    LasHeader header;
    header.offset = load_little<std::uint32_t>(bytes.data() + 96);
    header.stride = load_little<std::uint16_t>(bytes.data() + 105);
    header.count = load_little<std::uint32_t>(bytes.data() + 107);
    header.color = kRecords.at(format).color;
    if (minor >= 3 && bytes.size() >= kHeader13) header.end = load_little<std::uint64_t>(bytes.data() + 227);
    if (minor >= 4) {
      if (bytes.size() < kHeader14)
        return truncated("the header of LAS 1.4 takes " + std::to_string(kHeader14) + " bytes, " +
                         std::to_string(bytes.size()) + " are there");
      // Some programs fill the count of older versions alone.
      if (const auto count = load_little<std::uint64_t>(bytes.data() + 247); count > 0) header.count = count;
      const auto extended = load_little<std::uint64_t>(bytes.data() + 235);
      if (header.end == 0 || (extended != 0 && extended < header.end)) header.end = extended;
    }
    if (header.stride < kRecords.at(format).length) {
      return malformed("point records of " + std::to_string(header.stride) + " bytes; format " +
                       std::to_string(format) + " takes " + std::to_string(kRecords.at(format).length));
    }
    if (header.offset < kHeader)
      return malformed("the point records begin within the header, at byte " + std::to_string(header.offset));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      header.scale[axis] = load_little<double>(bytes.data() + 131 + 8 * axis);
      header.shift[axis] = load_little<double>(bytes.data() + 155 + 8 * axis);
      if (std::isfinite(header.scale[axis]) && header.scale[axis] != 0 && std::isfinite(header.shift[axis])) continue;
      return malformed(std::string("the scale of ") + "xyz"[axis] + " is " + std::to_string(header.scale[axis]) +
                       ", its offset " + std::to_string(header.shift[axis]));
    }
    return header;
  }

  /// Takes fewer points than declared, if that is wanted. More of them than declared are warned of: a header that was
  /// not finished counts too few.
  Status check_size(LasHeader& header) {
    const std::uint64_t size = source_.remaining();
    // What lies before the points does not end them: a field that nobody filled.
    const std::uint64_t end = header.end < header.offset ? size : std::min(size, header.end);
    const std::uint64_t room = end < header.offset ? 0 : (end - header.offset) / header.stride;
    const std::string declared =
        "the LAS declares " + std::to_string(header.count) + " points, " + std::to_string(room) + " are there";
    if (header.count == 0 && (room == 0 || !take_truncated_)) {
      return error(ErrorCode::empty_input,
                   room == 0 ? "the LAS declares 0 points" : declared + "; truncated=take reads them");
    }
    if (header.count > most_) return too_many(name_, header.count, most_);
    if (header.count == 0) {
      warnings_.push_back(declared + ", all of which are read");
      header.count = std::min(room, most_);
    } else if (header.count < room) {
      warnings_.push_back(declared + "; those beyond the declared ones are left out");
    } else if (header.count > room) {
      if (!take_truncated_ || room == 0) return truncated(declared + "; truncated=take reads what is there");
      warnings_.push_back(declared + ", all of which are read");
      header.count = room;
    }
    return Done{};
  }

  Result<RawCloud> read_records(const LasHeader& header) {
    RawCloud cloud;
    cloud.warnings = std::move(warnings_);
    std::vector<WideColor> colors;
    cloud.positions.resize(static_cast<std::size_t>(header.count));
    if (header.color != 0) colors.resize(cloud.size());
    for (std::size_t done = 0; done < cloud.size();) {
      const std::span<const std::byte> window = source_.peek(header.stride);
      const std::size_t count = std::min({window.size() / header.stride, kRecordsAtOnce, cloud.size() - done});
      if (count == 0) return truncated("the file ends within point " + std::to_string(done));
      for (std::size_t i = 0; i < count; ++i) {
        const std::byte* const record = window.data() + i * header.stride;
        Point3& p = cloud.positions[done + i];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          p[axis] = load_little<std::int32_t>(record + 4 * axis) * header.scale[axis] + header.shift[axis];
        }
        if (header.color == 0) continue;
        for (std::size_t c = 0; c < 3; ++c) {
          colors[done + i].at(c) = static_cast<float>(load_little<std::uint16_t>(record + header.color + 2 * c));
        }
      }
      source_.advance(count * header.stride);
      done += count;
    }
    const bool black = std::ranges::all_of(colors, [](const WideColor& c) { return c == WideColor{}; });
    if (!black) cloud.colors = to_bytes(colors, false, false, cloud.warnings);
    return cloud;
  }

  ByteSource& source_;
  std::string_view name_;
  std::uint64_t most_;
  bool take_truncated_;
  std::vector<std::string> warnings_;
};

}  // namespace

Result<RawCloud> read_las_cloud(ByteSource& source, std::string_view name, const ReadOptions& options) {
  return LasReader(source, name, options).run();
}

}  // namespace surfaced::io
