// SPDX-License-Identifier: GPL-3.0-or-later
// STL, binary and ascii: the vertices as a cloud, or the triangles joined where positions are equal.
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/text.hpp"
#include "io/formats.hpp"
#include "io/ply_ascii.hpp"
#include "io/scalars.hpp"
#include "io/stl_binary.hpp"
#include "io/text.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

/// Facets converted at once.
constexpr std::size_t kFacetsAtOnce = 1024;

using Corners = std::array<std::array<float, 3>, 3>;

/// Calls sink(corners) for every facet of a binary file.
template <class Sink>
Status read_binary(ByteSource& source, std::string_view name, Sink sink) {
  const std::span<const std::byte> head = source.peek(kStlHeader + 4);
  const auto count = load_little<std::uint32_t>(head.data() + kStlHeader);
  source.advance(kStlHeader + 4);
  if (count > source.remaining() / kStlFacet) {
    return Error{ErrorCode::truncated_input, std::string(name) + ": the STL declares " + std::to_string(count) +
                                                 " facets, " + std::to_string(source.remaining() / kStlFacet) +
                                                 " are there"};
  }
  for (std::uint32_t done = 0; done < count;) {
    const std::span<const std::byte> window = source.peek(kStlFacet);
    const std::size_t whole =
        std::min({window.size() / kStlFacet, kFacetsAtOnce, static_cast<std::size_t>(count - done)});
    if (whole == 0)
      return Error{ErrorCode::truncated_input,
                   std::string(name) + ": the file ends within facet " + std::to_string(done)};
    for (std::size_t f = 0; f < whole; ++f) {
      Corners corners;
      for (std::size_t k = 0; k < 9; ++k) {
        corners.at(k / 3).at(k % 3) = load_little<float>(window.data() + f * kStlFacet + 12 + 4 * k);
      }
      if (Status status = sink(corners); !status) return status;
    }
    source.advance(whole * kStlFacet);
    done += static_cast<std::uint32_t>(whole);
  }
  return Done{};
}

/// After the facets of a binary file, or the last solid of an ascii one: a sentence if more follows.
void warn_of_rest(std::uint64_t left, StlKind kind, std::vector<std::string>& warnings) {
  if (left == 0) return;
  warnings.push_back(std::to_string(left) + (kind == StlKind::binary ? " bytes after the last facet ignored"
                                                                     : " lines after the last 'endsolid' ignored"));
}

/// Walks the words of an ascii file; what follows `solid`, `endsolid` and `normal` is not looked at.
template <class Sink>
class AsciiStl {
 public:
  AsciiStl(ByteSource& source, std::string_view name, Sink sink)
      : name_(name), lines_(source, name), sink_(std::move(sink)) {}

  /// @return  the lines behind the last solid.
  Result<std::uint64_t> run() {
    std::uint64_t behind = 0;
    for (;;) {
      const Result<bool> there = lines_.next();
      if (!there) return there.error();
      if (!*there) break;
      std::string_view rest = lines_.text();
      const std::string word = in_lower_case(take_word(rest).substr(0, 16));
      if (ended_ && word != "solid") {
        if (!word.empty()) ++behind;
        continue;
      }
      if (Status status = read(word, rest); !status) return std::move(status).error();
    }
    if (ended_) return behind;
    return Error{ErrorCode::truncated_input, std::string(name_) + ": the ascii STL ends without 'endsolid' after " +
                                                 std::to_string(facets_) + " facets"};
  }

 private:
  Status read(const std::string& word, std::string_view rest) {
    if (word.empty()) return Done{};
    if (word == "vertex") return read_vertex(rest);
    if (word == "solid" || word == "endsolid") {
      ended_ = word == "endsolid";
      return corner_ == 0 ? Status(Done{}) : Status(lines_.malformed("a facet is not finished"));
    }
    if (word == "facet" || word == "outer" || word == "endloop") return Done{};
    if (word != "endfacet") return lines_.malformed("begins with " + in_quotes(word) + ", no word of STL");
    if (corner_ != 3) return lines_.malformed("a facet of " + std::to_string(corner_) + " vertices");
    corner_ = 0;
    ++facets_;
    return sink_(corners_);
  }

  Status read_vertex(std::string_view rest) {
    if (corner_ == 3) return lines_.malformed("a facet of more than 3 vertices");
    for (float& x : corners_.at(corner_)) {
      const std::string_view word = take_word(rest);
      double value = 0;
      if (!parse_number(word, Scalar::float32, value)) return lines_.malformed(in_quotes(word) + " is no number");
      x = static_cast<float>(value);
    }
    if (!trimmed(rest).empty()) return lines_.malformed("more than 3 values");
    ++corner_;
    return Done{};
  }

  std::string_view name_;
  TextLines lines_;
  Sink sink_;
  Corners corners_{};
  std::size_t corner_ = 0;
  std::size_t facets_ = 0;
  bool ended_ = false;
};

/// @return  what follows the facets: bytes or lines.
template <class Sink>
Result<std::uint64_t> read_facets(ByteSource& source, std::string_view name, StlKind kind, Sink sink) {
  if (kind == StlKind::binary) {
    if (Status status = read_binary(source, name, sink); !status) return std::move(status).error();
    return source.remaining();
  }
  return AsciiStl<Sink>(source, name, sink).run();
}

/// Numbers equal positions alike: open addressing over their bits.
class Joiner {
 public:
  explicit Joiner(std::vector<Point3>& positions) : positions_(positions), slots_(64) {}

  VertexIndex vertex(const std::array<float, 3>& corner, const Point3& origin) {
    if (2 * positions_.size() >= slots_.size()) grow();
    const Key key = key_of(corner);
    for (std::size_t at = hash(key);; ++at) {
      VertexIndex& slot = slots_[at & (slots_.size() - 1)];
      if (slot.valid() && keys_[slot] != key) continue;
      if (!slot.valid()) {
        slot = VertexIndex(positions_.size());
        keys_.push_back(key);
        Point3 position;
        const bool shifted = origin != Point3{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto x = static_cast<double>(corner[axis]);
          position[axis] = shifted ? x + origin[axis] : x;  // x + 0 would turn -0 into 0
        }
        positions_.push_back(position);
      }
      return slot;
    }
  }

 private:
  using Key = std::array<std::uint32_t, 3>;
  static Key key_of(const std::array<float, 3>& c) {
    return {std::bit_cast<std::uint32_t>(c[0]), std::bit_cast<std::uint32_t>(c[1]), std::bit_cast<std::uint32_t>(c[2])};
  }
  static std::size_t hash(const Key& key) {
    std::uint64_t h = 0;
    for (const std::uint32_t part : key) {
      h = (h ^ part) * 0x9E3779B97F4A7C15U;
      h ^= h >> 29;
    }
    return static_cast<std::size_t>(h);
  }
  void grow() {
    slots_.assign(2 * slots_.size(), VertexIndex());
    for (std::size_t v = 0; v < keys_.size(); ++v) {
      std::size_t at = hash(keys_[v]);
      while (slots_[at & (slots_.size() - 1)].valid()) ++at;
      slots_[at & (slots_.size() - 1)] = VertexIndex(v);
    }
  }

  std::vector<Point3>& positions_;
  std::vector<Key> keys_;
  std::vector<VertexIndex> slots_;
};

/// Text, then zeros, as programs fill the header; and a count below 2^24, whose highest byte is one that text does not
/// have.
bool has_header_of_text(std::string_view start) {
  if (start[kStlHeader + 3] != '\0') return false;
  const std::string_view header = start.substr(0, kStlHeader);
  const std::size_t end = std::min(header.find('\0'), header.size());
  return std::ranges::all_of(header.substr(0, end), [](char c) { return c >= ' ' && c <= '~'; }) &&
         std::ranges::all_of(header.substr(end), [](char c) { return c == '\0'; });
}

/// Whether the first facets are such as a mesh has: a file longer or shorter than its count says is told by them.
bool begins_with_facets(std::span<const std::byte> bytes, std::uint32_t count) {
  constexpr std::size_t kLookedAt = 16;
  const std::size_t facets = std::min({kLookedAt, bytes.size() / kStlFacet, static_cast<std::size_t>(count)});
  for (std::size_t f = 0; f < facets; ++f) {
    for (std::size_t k = 0; k < 12; ++k) {
      const double x = std::abs(static_cast<double>(load_little<float>(bytes.data() + f * kStlFacet + 4 * k)));
      const double most = k < 3 ? 1.01 : 1e15;  // a normal is no longer than 1
      if (!(x <= most) || (x > 0 && x < 1e-20)) return false;
    }
  }
  return facets > 0;
}

Error no_facets(std::string_view name) {
  return {ErrorCode::empty_input, std::string(name) + ": the STL has no facets"};
}

}  // namespace

std::optional<StlKind> stl_kind_of(std::span<const std::byte> start, std::uint64_t size) {
  const std::string_view text = text_of(start);
  const bool solid = in_lower_case(text.substr(0, 5)) == "solid";
  if (start.size() >= kStlHeader + 4) {
    const auto count = load_little<std::uint32_t>(start.data() + kStlHeader);
    if (size == kStlHeader + 4 + kStlFacet * std::uint64_t{count}) return StlKind::binary;
    // Binary files begin with 'solid' too; the count's bytes tell them.
    if (solid && text.substr(0, kStlHeader + 4).find('\0') != std::string_view::npos) return StlKind::binary;
    if (!solid && count > 0 && has_header_of_text(text) && begins_with_facets(start.subspan(kStlHeader + 4), count)) {
      return StlKind::binary;
    }
  }
  return solid ? std::optional(StlKind::ascii) : std::nullopt;
}

Result<RawCloud> read_stl_cloud(ByteSource& source, std::string_view name, StlKind kind, const ReadLimits& limits) {
  const std::uint64_t most = most_points(limits);
  const Point3 origin = kind == StlKind::binary ? stl_origin_in(text_of(source.peek(kStlHeader))) : Point3{};
  RawCloud cloud;
  if (kind == StlKind::binary) {
    // What the count could claim is checked when it is read; what is there is the bound.
    const std::uint64_t corners = 3 * (source.remaining() / kStlFacet);
    if (corners > most) return too_many(name, corners, most);
    cloud.positions.reserve(static_cast<std::size_t>(corners));
  }
  Result<std::uint64_t> left = read_facets(source, name, kind, [&](const Corners& corners) -> Status {
    if (cloud.size() + 3 > most) return too_many(name, cloud.size() + 3, most);
    for (const auto& c : corners) {
      cloud.positions.push_back({static_cast<double>(c[0]) + origin[0], static_cast<double>(c[1]) + origin[1],
                                 static_cast<double>(c[2]) + origin[2]});
    }
    return Done{};
  });
  if (!left) return std::move(left).error();
  if (cloud.size() == 0) return no_facets(name);
  warn_of_rest(*left, kind, cloud.warnings);
  cloud.source.faces = cloud.size() / 3;
  return cloud;
}

Result<TriangleMesh> read_stl_mesh(ByteSource& source, std::string_view name, StlKind kind,
                                   std::vector<std::string>& warnings) {
  TriangleMesh mesh;
  Joiner joiner(mesh.positions);
  std::size_t degenerate = 0;
  const Point3 origin = kind == StlKind::binary ? stl_origin_in(text_of(source.peek(kStlHeader))) : Point3{};
  Result<std::uint64_t> left = read_facets(source, name, kind, [&](const Corners& corners) -> Status {
    const Triangle t{joiner.vertex(corners[0], origin), joiner.vertex(corners[1], origin),
                     joiner.vertex(corners[2], origin)};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      ++degenerate;
    } else {
      mesh.triangles.push_back(t);
    }
    return Done{};
  });
  if (!left) return std::move(left).error();
  if (mesh.positions.empty()) return no_facets(name);
  warn_of_rest(*left, kind, warnings);
  warn_of_degenerate(degenerate, warnings);
  return mesh;
}

}  // namespace surfaced::io
