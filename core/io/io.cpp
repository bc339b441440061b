// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/io.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <stdexcept>
#include <utility>

#include "io/bytes.hpp"
#include "io/formats.hpp"
#include "io/ply_header.hpp"

namespace surfaced {
namespace {

using io::ByteSource;

/// Enough of a file to tell its format: text may begin with comments.
constexpr std::size_t kSniffed = std::size_t{16} << 10;
/// Enough of a file to show what it is.
constexpr std::size_t kShown = 16;
constexpr std::string_view kDracoMagic = "DRACO";

constexpr auto kExtensions = std::to_array<std::pair<std::string_view, MeshFormat>>({
    {".glb", MeshFormat::glb},
    {".gltf", MeshFormat::gltf},
    {".drc", MeshFormat::drc},
    {".ply", MeshFormat::ply},
    {".obj", MeshFormat::obj},
    {".stl", MeshFormat::stl},
    {".3mf", MeshFormat::threemf},
});

/// Runs a reader or writer and turns what it throws into errors: the wall of this room.
template <class T, class Work>
Result<T> guarded(std::string_view name, Work work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, std::string(name) + ": not enough memory to hold it"};
  } catch (const std::length_error& error) {
    return Error{ErrorCode::out_of_memory, std::string(name) + ": larger than any array can be (" + error.what() + ")"};
  } catch (const std::exception& error) {
    return Error{ErrorCode::internal_error, std::string(name) + ": " + error.what()};
  }
}

/// What a file of no known format begins with.
std::string shown(std::span<const std::byte> bytes) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string hex;
  std::string text;
  for (const std::byte b : bytes.first(std::min(bytes.size(), kShown))) {
    const auto value = std::to_integer<unsigned>(b);
    hex += hex.empty() ? "" : " ";
    hex += kHex[value >> 4];
    hex += kHex[value & 15U];
    text += value >= ' ' && value <= '~' ? static_cast<char>(value) : '.';
  }
  return "'" + text + "' (" + hex + ")";
}

bool starts_with(std::span<const std::byte> bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin(), [](char a, std::byte b) {
           return static_cast<unsigned char>(a) == std::to_integer<unsigned char>(b);
         });
}

/// What people send that is no cloud, or none that is read here.
constexpr auto kStrangers = std::to_array<std::pair<std::string_view, std::string_view>>({
    {"\x89PNG", "a PNG picture"},
    {"PK\x03\x04", "a ZIP archive; send the file that is in it"},
    {"\x1f\x8b", "gzip; unpack it first"},
    {"ASTM-E57", "an E57 scan; convert it to LAS, PLY or PTS"},
    {"OFF", "an OFF mesh; convert it to OBJ or PLY"},
});

Error unknown_format(std::span<const std::byte> start, std::string_view name, const std::string& known) {
  std::string what;
  for (const auto& [magic, stranger] : kStrangers) {
    if (starts_with(start, magic)) what = ", " + std::string(stranger);
  }
  return {ErrorCode::unknown_format, std::string(name) + " begins with " + shown(start) + what + "; " + known};
}

/// A GLB, or text that begins with an object.
bool looks_like_gltf(std::span<const std::byte> bytes) {
  const auto blank = [](std::byte b) {
    return b == std::byte{' '} || b == std::byte{'\t'} || b == std::byte{'\n'} || b == std::byte{'\r'};
  };
  const auto first = std::ranges::find_if_not(bytes, blank);
  return starts_with(bytes, "glTF") || (first != bytes.end() && *first == std::byte{'{'});
}

/// Skips the byte order mark that some programs write before text.
void skip_mark(ByteSource& source) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (starts_with(source.peek(kSniffed), kMark)) source.advance(kMark.size());
}

/// The start as text.
std::string_view text_at(ByteSource& source) {
  const std::span<const std::byte> start = source.peek(kSniffed);
  return {reinterpret_cast<const char*>(start.data()), std::min(start.size(), kSniffed)};
}

Result<RawCloud> parse(ByteSource& source, std::string_view name, const ReadLimits& limits) {
  skip_mark(source);
  const std::span<const std::byte> start = source.peek(kSniffed);
  if (source.failure()) return *source.failure();
  if (start.empty()) return Error{ErrorCode::empty_input, std::string(name) + " has 0 bytes"};
  if (io::looks_like_ply(start)) return io::read_ply_cloud(source, name, limits);
  if (starts_with(start, kDracoMagic)) return io::read_draco_cloud(source.rest(), name, limits);
  if (starts_with(start, "LASF")) return io::read_las_cloud(source, name, limits);
  if (looks_like_gltf(start)) return io::read_gltf_cloud(source.rest(), name, limits);
  if (const auto stl = io::stl_kind_of(start, source.remaining()))
    return io::read_stl_cloud(source, name, *stl, limits);
  const std::string_view text = text_at(source);
  if (io::looks_like_pcd(text)) return io::read_pcd_cloud(source, name, limits);
  if (io::looks_like_obj(text)) return io::read_obj_cloud(source, name, limits);
  if (io::looks_like_text_cloud(text)) return io::read_text_cloud(source, name, limits);
  return unknown_format(
      source.peek(kSniffed), name,
      "a PLY begins with 'ply', a Draco file with 'DRACO', a LAS with 'LASF', a PCD with '# .PCD', a "
      "GLB with 'glTF', an OBJ with statements such as 'v', text with numbers or a header x, y, z; an STL "
      "is told by its length or by 'solid'");
}

Result<TriangleMesh> parse_mesh(ByteSource& source, std::string_view name, std::vector<std::string>* warnings) {
  skip_mark(source);
  const std::span<const std::byte> start = source.peek(kSniffed);
  if (source.failure()) return *source.failure();
  if (start.empty()) return Error{ErrorCode::empty_input, std::string(name) + " has 0 bytes"};
  std::vector<std::string> unheard;
  std::vector<std::string>& heard = warnings == nullptr ? unheard : *warnings;
  if (io::looks_like_ply(start)) return io::read_ply_mesh(source, name, heard);
  if (starts_with(start, kDracoMagic)) return io::read_draco_mesh(source.rest(), name, {}, heard);
  if (looks_like_gltf(start)) return io::read_gltf_mesh(source.rest(), name, heard);
  if (starts_with(start, "PK\x03\x04")) return io::read_3mf_mesh(source.rest(), name, heard);
  if (const auto stl = io::stl_kind_of(start, source.remaining())) return io::read_stl_mesh(source, name, *stl, heard);
  if (io::looks_like_obj(text_at(source))) return io::read_obj_mesh(source, name, heard);
  return unknown_format(
      source.peek(kSniffed), name,
      "a PLY begins with 'ply', a Draco file with 'DRACO', a GLB with 'glTF', a glTF with '{', an OBJ "
      "with statements such as 'v'; an STL is told by its length or by 'solid'");
}

/// What no format could hold. Says which vertex or triangle it is.
Status check_mesh(const TriangleMesh& mesh) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = mesh.positions[i][axis];
      const auto narrow = static_cast<float>(x);
      if (std::isfinite(narrow)) continue;
      const ErrorCode code = std::isfinite(x) ? ErrorCode::coordinate_out_of_range : ErrorCode::coordinate_not_finite;
      return Error{code, "vertex " + std::to_string(i) + ": " + "xyz"[axis] + " = " + std::to_string(x) +
                             "; the largest float32 is 3.4028235e38"};
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const VertexIndex v : mesh.triangles[t]) {
      if (v < mesh.positions.size()) continue;
      return Error{ErrorCode::internal_error, "triangle " + std::to_string(t) + " refers to vertex " +
                                                  std::to_string(v.value) + " of " +
                                                  std::to_string(mesh.positions.size())};
    }
  }
  return Done{};
}

Status check_options(const TriangleMesh& mesh, const EncodeOptions& options) {
  constexpr int kLeastBits = 8;
  constexpr int kMostBits = 30;
  if (const auto bits = options.quantization_bits; bits && (*bits < kLeastBits || *bits > kMostBits)) {
    return Error{ErrorCode::invalid_parameter, "quantization is " + std::to_string(*bits) + " bits; " +
                                                   std::to_string(kLeastBits) + " to " + std::to_string(kMostBits) +
                                                   " are possible"};
  }
  for (const VertexScalar& scalar : options.scalars) {
    if (scalar.values.size() == mesh.positions.size()) continue;
    return Error{ErrorCode::internal_error, scalar.name + " has " + std::to_string(scalar.values.size()) +
                                                " values for " + std::to_string(mesh.positions.size()) + " vertices"};
  }
  return Done{};
}

}  // namespace

namespace io {

void warn_of_degenerate(std::size_t triangles, std::vector<std::string>& warnings) {
  if (triangles > 0) warnings.push_back(std::to_string(triangles) + " triangles with a repeated vertex left out");
}

std::uint64_t most_points(const ReadLimits& limits) {
  return std::min<std::uint64_t>(limits.max_points, VertexIndex::kNone);
}

Error too_many(std::string_view name, std::uint64_t points, std::uint64_t limit) {
  return {ErrorCode::too_many_points,
          std::string(name) + ": " + std::to_string(points) + " points; the limit is " + std::to_string(limit)};
}

}  // namespace io

Result<RawCloud> read_cloud(const std::filesystem::path& path, const ReadLimits& limits, std::string_view name) {
  const std::string called = name.empty() ? path.filename().string() : std::string(name);
  return guarded<RawCloud>(called, [&]() -> Result<RawCloud> {
    Result<ByteSource> source = ByteSource::open(path);
    if (!source) return std::move(source).error();
    return parse(*source, called, limits);
  });
}

Result<RawCloud> parse_cloud(std::span<const std::byte> bytes, std::string_view name, const ReadLimits& limits) {
  return guarded<RawCloud>(name, [&] {
    ByteSource source(bytes);
    return parse(source, name, limits);
  });
}

Result<MeshFormat> mesh_format_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  const auto* found =
      std::ranges::find(kExtensions, std::string_view(extension), [](const auto& row) { return row.first; });
  if (found != kExtensions.end()) return found->second;
  std::string known;
  for (const auto& [name, format] : kExtensions) known += (known.empty() ? "" : ", ") + std::string(name);
  return Error{ErrorCode::unknown_output,
               "the extension '" + extension + "' of " + path.filename().string() + " is none of " + known};
}

std::string_view name_of(MeshFormat format) {
  const auto* found = std::ranges::find(kExtensions, format, [](const auto& row) { return row.second; });
  return found->first.substr(1);
}

Result<std::vector<std::byte>> encode_mesh(const TriangleMesh& mesh, MeshFormat format, const EncodeOptions& options) {
  return guarded<std::vector<std::byte>>("the mesh", [&]() -> Result<std::vector<std::byte>> {
    if (Status status = check_mesh(mesh); !status) return std::move(status).error();
    if (Status status = check_options(mesh, options); !status) return std::move(status).error();
    if (format == MeshFormat::ply) return io::write_ply_mesh(mesh, options.scalars);
    if (format == MeshFormat::drc) return io::write_draco(mesh, options.quantization_bits);
    if (format == MeshFormat::obj) return io::write_obj_mesh(mesh);
    if (format == MeshFormat::stl) return io::write_stl_mesh(mesh);
    if (format == MeshFormat::threemf) return io::write_3mf_mesh(mesh, options);
    return io::write_gltf(mesh, format, options);
  });
}

Result<TriangleMesh> decode_mesh(std::span<const std::byte> bytes, std::string_view name,
                                 std::vector<std::string>* warnings) {
  return guarded<TriangleMesh>(name, [&] {
    ByteSource source(bytes);
    return parse_mesh(source, name, warnings);
  });
}

Result<TriangleMesh> read_mesh(const std::filesystem::path& path, std::vector<std::string>* warnings) {
  return guarded<TriangleMesh>(path.string(), [&]() -> Result<TriangleMesh> {
    Result<ByteSource> source = ByteSource::open(path);
    if (!source) return std::move(source).error();
    return parse_mesh(*source, path.filename().string(), warnings);
  });
}

}  // namespace surfaced
