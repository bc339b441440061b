// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <bit>
#include <limits>
#include <optional>
#include <utility>

#include "io/formats.hpp"
#include "io/ply_ascii.hpp"
#include "io/ply_header.hpp"
#include "io/ply_vertices.hpp"
#include "io/scalars.hpp"
#include "io/text.hpp"

namespace surfaced::io {
namespace {

/// Bytes of rows converted at once: they and the points made from them stay in the cache.
constexpr std::size_t kBytesOfRows = std::size_t{64} << 10;

/// The integer or float at `from`, as a double, which holds every PLY scalar.
template <bool Swapped>
double load_scalar(Scalar type, const std::byte* from) {
  switch (type) {
    case Scalar::int8:
      return load<std::int8_t, Swapped>(from);
    case Scalar::uint8:
      return load<std::uint8_t, Swapped>(from);
    case Scalar::int16:
      return load<std::int16_t, Swapped>(from);
    case Scalar::uint16:
      return load<std::uint16_t, Swapped>(from);
    case Scalar::int32:
      return load<std::int32_t, Swapped>(from);
    case Scalar::uint32:
      return load<std::uint32_t, Swapped>(from);
    case Scalar::float32:
      return static_cast<double>(load<float, Swapped>(from));
    case Scalar::float64:
      break;
  }
  return load<double, Swapped>(from);
}

/// Polygons on their way into triangles, fans around their first corner.
class FaceSink {
 public:
  FaceSink(TriangleMesh& mesh, std::size_t vertices) : mesh_(mesh), vertices_(vertices) {}

  void begin_face() { corners_ = 0; }

  /// False if the index is no vertex.
  bool push_corner(double index) {
    if (!(index >= 0) || index >= static_cast<double>(vertices_)) return false;
    const VertexIndex v(static_cast<std::size_t>(index));
    if (corners_ == 0) first_ = v;
    if (corners_ >= 2) push_triangle({first_, last_, v});
    last_ = v;
    ++corners_;
    return true;
  }

  std::size_t degenerate() const { return degenerate_; }

 private:
  void push_triangle(const Triangle& t) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      ++degenerate_;
    } else {
      mesh_.triangles.push_back(t);
    }
  }

  TriangleMesh& mesh_;
  std::size_t vertices_;
  VertexIndex first_;
  VertexIndex last_;
  std::uint64_t corners_ = 0;
  std::size_t degenerate_ = 0;
};

/// Walks the elements of a file once, in order.
class PlyReader {
 public:
  PlyReader(ByteSource& source, std::string_view name, const PlyHeader& header)
      : source_(source),
        name_(name),
        header_(header),
        ascii_(header.encoding == PlyEncoding::ascii),
        swapped_((header.encoding == PlyEncoding::binary_big_endian) != (std::endian::native == std::endian::big)),
        rows_(source) {}

  /// Reads all elements; those without a sink are checked for length and skipped.
  Status run(VertexSink* vertices, FaceSink* faces) {
    for (const PlyElement& element : header_.elements) {
      vertices_ = element.name == "vertex" ? vertices : nullptr;
      faces_ = element.name == "face" ? faces : nullptr;
      corners_ = faces_ == nullptr ? std::nullopt : corner_property(element);
      Status status = ascii_                ? read_ascii(element)
                      : element.has_lists() ? (swapped_ ? read_lists<true>(element) : read_lists<false>(element))
                                            : read_fixed(element);
      if (!status) return source_.failure() ? Status(*source_.failure()) : std::move(status);
    }
    return Done{};
  }

  /// After run: a sentence if more follows than blanks, as when a count is too small.
  void warn_of_rest(std::vector<std::string>& warnings) {
    if (rows_.begin_row()) {
      warnings.push_back(std::to_string(source_.remaining()) + " bytes after the last element ignored");
    }
  }

  static std::optional<std::size_t> corner_property(const PlyElement& element) {
    for (const std::string_view name : {"vertex_indices", "vertex_index"}) {
      const auto found = element.find(name);
      if (found && element.properties[*found].is_list()) return found;
    }
    return std::nullopt;
  }

 private:
  std::string row_name(const PlyElement& element, std::uint64_t row) const {
    return std::string(name_) + ": element " + in_quotes(element.name) + ", row " + std::to_string(row + 1) + " of " +
           std::to_string(element.count);
  }
  Error truncated(const PlyElement& element, std::uint64_t row) const {
    return {ErrorCode::truncated_input, std::string(name_) + ": the file ends in element " + in_quotes(element.name) +
                                            ": " + std::to_string(row) + " of " + std::to_string(element.count) +
                                            " rows are there"};
  }
  Error malformed(const PlyElement& element, std::uint64_t row, const std::string& what) const {
    return {ErrorCode::malformed_input, row_name(element, row) + ": " + what};
  }
  Error bad_corner(const PlyElement& element, std::uint64_t row, double index) const {
    const PlyElement* vertex = header_.find("vertex");
    return malformed(element, row,
                     "the vertex index " + std::to_string(static_cast<std::int64_t>(index)) +
                         " is not below the number of vertices, " +
                         std::to_string(vertex == nullptr ? 0 : vertex->count));
  }

  Status read_fixed(const PlyElement& element) {
    const std::size_t stride = element.least_binary_row();
    if (stride == 0) return Done{};
    if (vertices_ == nullptr) {
      const std::uint64_t there = source_.remaining() / stride;
      if (!source_.skip(element.count * stride)) return truncated(element, there);
      return Done{};
    }
    vertices_->reserve(static_cast<std::size_t>(element.count));
    std::uint64_t row = 0;
    while (row < element.count) {
      const std::span<const std::byte> window = source_.peek(stride);
      const std::uint64_t whole =
          std::min<std::uint64_t>(window.size() / stride, std::max(kBytesOfRows / stride, std::size_t{1}));
      const auto count = static_cast<std::size_t>(std::min(element.count - row, whole));
      if (count == 0) return truncated(element, row);
      vertices_->push_rows(window.data(), stride, count, swapped_);
      source_.advance(count * stride);
      row += count;
    }
    return Done{};
  }

  template <bool Swapped>
  Status read_lists(const PlyElement& element) {
    if (vertices_ != nullptr) vertices_->reserve(static_cast<std::size_t>(element.count));
    VertexRow values{};
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (faces_ != nullptr) faces_->begin_face();
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        if (property.is_list()) {
          if (Status status = read_list<Swapped>(element, row, p); !status) return status;
          continue;
        }
        const std::size_t size = size_of(property.type);
        const std::span<const std::byte> window = source_.peek(size);
        if (window.size() < size) return truncated(element, row);
        if (vertices_ != nullptr) store(values, p, load_scalar<Swapped>(property.type, window.data()));
        source_.advance(size);
      }
      if (vertices_ != nullptr) vertices_->push(values);
    }
    return Done{};
  }

  template <bool Swapped>
  Status read_list(const PlyElement& element, std::uint64_t row, std::size_t p) {
    const PlyProperty& property = element.properties[p];
    const std::size_t count_size = size_of(*property.count_type);
    std::span<const std::byte> window = source_.peek(count_size);
    if (window.size() < count_size) return truncated(element, row);
    const double declared = load_scalar<Swapped>(*property.count_type, window.data());
    source_.advance(count_size);
    if (declared < 0)
      return malformed(element, row, "a list of " + std::to_string(static_cast<int>(declared)) + " values");
    const auto count = static_cast<std::uint64_t>(declared);
    const std::size_t size = size_of(property.type);
    if (count > source_.remaining() / size) return truncated(element, row);
    if (corners_ != p) return source_.skip(count * size) ? Status(Done{}) : Status(truncated(element, row));
    for (std::uint64_t i = 0; i < count; ++i) {
      window = source_.peek(size);
      if (window.size() < size) return truncated(element, row);
      const double index = load_scalar<Swapped>(property.type, window.data());
      if (!faces_->push_corner(index)) return bad_corner(element, row, index);
      source_.advance(size);
    }
    return Done{};
  }

  Status read_ascii(const PlyElement& element) {
    if (element.properties.empty()) return Done{};
    if (vertices_ != nullptr) vertices_->reserve(static_cast<std::size_t>(element.count));
    VertexRow values{};
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (!rows_.begin_row()) return truncated(element, row);
      if (faces_ != nullptr) faces_->begin_face();
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        Status status = element.properties[p].is_list() ? read_ascii_list(element, row, p)
                                                        : read_ascii_scalar(element, row, p, values);
        if (!status) return status;
      }
      if (!rows_.at_line_end())
        return malformed(element, row, "the line has more values than the element has properties");
      if (vertices_ != nullptr) vertices_->push(values);
    }
    return Done{};
  }

  Status read_ascii_scalar(const PlyElement& element, std::uint64_t row, std::size_t p, VertexRow& values) {
    const std::string_view text = rows_.token();
    if (text.empty()) return line_too_short(element, row, p);
    if (vertices_ == nullptr || vertices_->layout().slots()[p] == Slot::none) return Done{};
    double value = 0;
    if (!parse_number(text, element.properties[p].type, value)) return bad_number(element, row, p, text);
    store(values, p, value);
    return Done{};
  }

  Status read_ascii_list(const PlyElement& element, std::uint64_t row, std::size_t p) {
    const PlyProperty& property = element.properties[p];
    std::string_view text = rows_.token();
    if (text.empty()) return line_too_short(element, row, p);
    double declared = 0;
    if (!parse_number(text, *property.count_type, declared) || declared < 0) return bad_number(element, row, p, text);
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(declared); ++i) {
      text = rows_.token();
      if (text.empty()) return line_too_short(element, row, p);
      if (corners_ != p) continue;
      double index = 0;
      if (!parse_number(text, property.type, index)) return bad_number(element, row, p, text);
      if (!faces_->push_corner(index)) return bad_corner(element, row, index);
    }
    return Done{};
  }

  Error line_too_short(const PlyElement& element, std::uint64_t row, std::size_t p) {
    if (source_.remaining() == 0) return truncated(element, row);
    return malformed(element, row, "the line ends before property " + in_quotes(element.properties[p].name) + " does");
  }

  Error bad_number(const PlyElement& element, std::uint64_t row, std::size_t p, std::string_view text) const {
    return malformed(element, row,
                     "property " + in_quotes(element.properties[p].name) + ": " + in_quotes(text) +
                         " is no number of its declared type");
  }

  void store(VertexRow& values, std::size_t p, double value) const {
    const Slot slot = vertices_->layout().slots()[p];
    if (slot != Slot::none) values[static_cast<std::size_t>(slot)] = value;
  }

  ByteSource& source_;
  std::string_view name_;
  const PlyHeader& header_;
  bool ascii_;
  bool swapped_;
  AsciiRows rows_;
  VertexSink* vertices_ = nullptr;
  FaceSink* faces_ = nullptr;
  std::optional<std::size_t> corners_;
};

Result<VertexSink> make_sink(const PlyHeader& header, std::string_view name, const ReadOptions& options) {
  const PlyElement* vertex = header.find("vertex");
  if (vertex == nullptr) {
    return Error{ErrorCode::missing_positions, std::string(name) + ": the PLY has no element 'vertex'"};
  }
  Result<VertexLayout> layout = VertexLayout::of(*vertex, name, options.splats);
  if (!layout) return std::move(layout).error();
  if (vertex->count == 0) return Error{ErrorCode::empty_input, std::string(name) + ": the PLY declares 0 vertices"};
  if (vertex->count > most_points(options.limits)) return too_many(name, vertex->count, most_points(options.limits));
  return VertexSink(*vertex, std::move(*layout));
}

}  // namespace

Result<RawCloud> read_ply_cloud(ByteSource& source, std::string_view name, const ReadOptions& options) {
  const Result<PlyHeader> header = read_ply_header(source, name);
  if (!header) return header.error();
  Result<VertexSink> sink = make_sink(*header, name, options);
  if (!sink) return std::move(sink).error();
  PlyReader reader(source, name, *header);
  if (Status status = reader.run(&*sink, nullptr); !status) return std::move(status).error();
  RawCloud cloud = sink->finish();
  if (cloud.size() == 0) {
    return Error{ErrorCode::empty_input, std::string(name) + ": splat_opacity and splat_scale leave none of " +
                                             std::to_string(header->find("vertex")->count) + " Gaussians"};
  }
  reader.warn_of_rest(cloud.warnings);
  const PlyElement* face = header->find("face");
  if (face != nullptr && PlyReader::corner_property(*face)) cloud.source.faces = face->count;
  return cloud;
}

Result<TriangleMesh> read_ply_mesh(ByteSource& source, std::string_view name, std::vector<std::string>& warnings) {
  const Result<PlyHeader> header = read_ply_header(source, name);
  if (!header) return header.error();
  Result<VertexSink> sink = make_sink(*header, name, {});
  if (!sink) return std::move(sink).error();
  const PlyElement* face = header->find("face");
  if (face == nullptr || !PlyReader::corner_property(*face)) {
    return Error{ErrorCode::unsupported_feature,
                 std::string(name) + ": the PLY has no element 'face' with a list 'vertex_indices' or 'vertex_index'"};
  }
  TriangleMesh mesh;
  FaceSink faces(mesh, static_cast<std::size_t>(header->find("vertex")->count));
  PlyReader reader(source, name, *header);
  if (Status status = reader.run(&*sink, &faces); !status) return std::move(status).error();
  RawCloud cloud = sink->finish();
  warnings.insert(warnings.end(), cloud.warnings.begin(), cloud.warnings.end());
  reader.warn_of_rest(warnings);
  warn_of_degenerate(faces.degenerate(), warnings);
  mesh.positions = std::move(cloud.positions);
  mesh.normals = std::move(cloud.normals);
  mesh.colors = std::move(cloud.colors);
  return mesh;
}

}  // namespace surfaced::io
