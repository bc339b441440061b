// SPDX-License-Identifier: GPL-3.0-or-later
// Wavefront OBJ: vertices with the colours that many programs add to them, normals, faces.
#include <algorithm>
#include <optional>
#include <utility>

#include "io/colors.hpp"
#include "io/formats.hpp"
#include "io/ply_ascii.hpp"
#include "io/text.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

/// Statements that an OBJ may begin with.
constexpr auto kKeywords = std::to_array<std::string_view>(
    {"v", "vn", "vt", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl", "fo", "shadow_obj", "lod"});

/// Of a statement over several lines.
constexpr std::size_t kLongestStatement = std::size_t{1} << 20;

/// A corner of a face: indices from 1, or from the end where negative; 0 where absent.
struct Corner {
  std::int64_t vertex = 0;
  std::int64_t normal = 0;
};

class ObjReader {
 public:
  ObjReader(ByteSource& source, std::string_view name, const ReadLimits& limits, bool with_faces)
      : name_(name), lines_(source, name), most_(most_points(limits)), with_faces_(with_faces) {}

  Status run() {
    for (;;) {
      const Result<bool> there = lines_.next();
      if (!there) return there.error();
      if (!*there) break;
      statement_ = lines_.text();
      // A path in a comment may end so too.
      if (statement_.ends_with('\\') && !statement_.starts_with('#')) {
        if (Status joined = join_lines(); !joined) return joined;
      }
      std::string_view rest = statement_;
      const std::string_view keyword = take_word(rest);
      Status status = keyword == "v"                  ? read_vertex(rest)
                      : keyword == "vn"               ? read_normal(rest)
                      : keyword == "f" && with_faces_ ? read_face(rest)
                                                      : skip(keyword);
      if (!status) return status;
    }
    if (mesh.positions.empty()) return Error{ErrorCode::empty_input, std::string(name_) + ": the OBJ has no vertices"};
    finish();
    return Done{};
  }

  TriangleMesh mesh;
  std::vector<std::string> warnings;
  /// Faces that were left aside.
  std::uint64_t skipped_faces = 0;

 private:
  /// Makes a statement of the line and those that it continues in by a '\\' at its end.
  Status join_lines() {
    joined_.clear();
    for (bool more = true; more;) {
      joined_.append(lines_.text());
      more = joined_.ends_with('\\');
      if (!more) break;
      joined_.back() = ' ';
      if (joined_.size() > kLongestStatement) {
        return lines_.malformed("a statement of more than " + std::to_string(kLongestStatement) + " bytes");
      }
      const Result<bool> there = lines_.next();
      if (!there) return there.error();
      more = *there;
    }
    statement_ = joined_;
    return Done{};
  }

  Status skip(std::string_view keyword) {
    skipped_faces += keyword == "f" ? 1U : 0U;
    if (keyword.empty() || keyword.starts_with('#')) return Done{};
    const bool known = std::ranges::all_of(keyword, [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; });
    return known ? Status(Done{})
                 : Status(lines_.malformed("begins with " + in_quotes(keyword) + ", no statement of OBJ"));
  }

  /// `values` numbers at most; the count that is there.
  Result<std::size_t> numbers(std::string_view rest, std::span<double> values) const {
    std::size_t count = 0;
    for (std::string_view word = take_word(rest); !word.empty() && word.front() != '#'; word = take_word(rest)) {
      if (count == values.size()) return lines_.malformed("more than " + std::to_string(count) + " values");
      if (!parse_number(word, Scalar::float64, values[count]))
        return lines_.malformed(in_quotes(word) + " is no number");
      ++count;
    }
    return count;
  }

  /// x y z, x y z w, x y z r g b, or x y z r g b a.
  Status read_vertex(std::string_view rest) {
    std::array<double, 7> values{};
    const Result<std::size_t> count = numbers(rest, values);
    if (!count) return count.error();
    if (*count < 3 || *count == 5)
      return lines_.malformed(std::to_string(*count) + " values; a vertex has 3, 4, 6 or 7");
    if (mesh.positions.size() >= most_) return too_many(name_, mesh.positions.size() + 1, most_);
    mesh.positions.push_back({values[0], values[1], values[2]});
    if (*count >= 6) {
      const auto narrow = [&](std::size_t i) { return static_cast<float>(values.at(i)); };
      colors_.push_back({narrow(3), narrow(4), narrow(5), 0});
    }
    return Done{};
  }

  Status read_normal(std::string_view rest) {
    std::array<double, 3> values{};
    const Result<std::size_t> count = numbers(rest, values);
    if (!count) return count.error();
    if (*count != 3) return lines_.malformed(std::to_string(*count) + " values; a normal has 3");
    normals_.push_back({static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2])});
    return Done{};
  }

  static bool parse_index(std::string_view text, std::int64_t& index) {
    double value = 0;
    if (!parse_number(text, Scalar::int32, value)) return false;
    index = static_cast<std::int64_t>(value);
    return index != 0;
  }

  /// v, v/vt, v//vn or v/vt/vn.
  Result<Corner> corner_of(std::string_view word) const {
    const std::string_view whole = word;
    std::array<std::int64_t, 3> indices{};
    for (std::size_t i = 0; i < 3 && !word.empty(); ++i) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      const std::string_view part = word.substr(0, slash);
      if ((i == 0 || !part.empty()) && !parse_index(part, indices.at(i))) {
        return lines_.malformed(in_quotes(whole) + " is no corner of a face");
      }
      word.remove_prefix(std::min(slash + 1, word.size()));
    }
    return Corner{indices[0], indices[2]};
  }

  Result<VertexIndex> vertex_of(const Corner& corner) const {
    const auto count = static_cast<std::int64_t>(mesh.positions.size());
    const std::int64_t v = corner.vertex > 0 ? corner.vertex - 1 : count + corner.vertex;
    if (v >= 0 && v < count) return VertexIndex(static_cast<std::size_t>(v));
    return lines_.malformed("vertex " + std::to_string(corner.vertex) + " of a face; " + std::to_string(count) +
                            " vertices come before it");
  }

  /// A polygon as a fan around its first corner.
  Status read_face(std::string_view rest) {
    std::array<VertexIndex, 2> fan;
    std::size_t corners = 0;
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest), ++corners) {
      const Result<Corner> corner = corner_of(word);
      if (!corner) return corner.error();
      const Result<VertexIndex> v = vertex_of(*corner);
      if (!v) return v.error();
      normals_are_vertices_ &= corner->normal == static_cast<std::int64_t>(std::size_t{*v}) + 1;
      if (corners >= 2) push_triangle({fan[0], fan[1], *v});
      fan.at(corners == 0 ? 0 : 1) = *v;
    }
    if (corners >= 3) return Done{};
    return lines_.malformed("a face of " + std::to_string(corners) + " corners");
  }

  void push_triangle(const Triangle& t) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      ++degenerate_;
    } else {
      mesh.triangles.push_back(t);
    }
  }

  void finish() {
    // Without faces a normal belongs to the vertex beside it; faces say whose it is.
    const bool by_vertex = with_faces_ ? normals_are_vertices_ : skipped_faces == 0;
    if (normals_.size() == mesh.positions.size() && by_vertex) {
      mesh.normals = std::move(normals_);
    } else if (!normals_.empty()) {
      warnings.emplace_back("normals dropped: they do not belong to the vertices one by one");
    }
    if (colors_.size() == mesh.positions.size()) {
      mesh.colors = to_bytes(colors_, true, false, warnings);
    } else if (!colors_.empty()) {
      warnings.push_back("colours dropped: " + std::to_string(colors_.size()) + " of " +
                         std::to_string(mesh.positions.size()) + " vertices have one");
    }
    warn_of_degenerate(degenerate_, warnings);
  }

  std::string_view name_;
  TextLines lines_;
  std::uint64_t most_;
  bool with_faces_;
  std::string_view statement_;
  std::string joined_;
  std::vector<Normal3> normals_;
  std::vector<WideColor> colors_;
  bool normals_are_vertices_ = true;
  std::size_t degenerate_ = 0;
};

}  // namespace

Result<RawCloud> read_obj_cloud(ByteSource& source, std::string_view name, const ReadLimits& limits) {
  ObjReader reader(source, name, limits, false);
  if (Status status = reader.run(); !status) return std::move(status).error();
  return RawCloud{std::move(reader.mesh.positions), std::move(reader.mesh.normals), std::move(reader.mesh.colors),
                  std::move(reader.warnings), CloudSource{.format = {}, .table = {}, .faces = reader.skipped_faces}};
}

Result<TriangleMesh> read_obj_mesh(ByteSource& source, std::string_view name, std::vector<std::string>& warnings) {
  ObjReader reader(source, name, {}, true);
  if (Status status = reader.run(); !status) return std::move(status).error();
  warnings.insert(warnings.end(), reader.warnings.begin(), reader.warnings.end());
  return std::move(reader.mesh);
}

bool looks_like_obj(std::string_view start) {
  while (!start.empty()) {
    const std::size_t end = start.find_first_of("\r\n");
    std::string_view line = trimmed(start.substr(0, end));
    start.remove_prefix(std::min(end, start.size() - 1) + 1);
    if (line.empty() || line.starts_with('#')) continue;
    const std::string_view keyword = take_word(line);
    return !trimmed(line).empty() && std::ranges::find(kKeywords, keyword) != kKeywords.end();
  }
  return false;
}

}  // namespace surfaced::io
