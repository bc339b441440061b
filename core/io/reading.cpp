// SPDX-License-Identifier: GPL-3.0-or-later
// Telling formats apart by content, out of what files are wrapped in.
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "io/formats.hpp"
#include "io/guarded.hpp"
#include "io/io.hpp"
#include "io/ply_header.hpp"
#include "io/strangers.hpp"
#include "io/text.hpp"
#include "io/unpacking.hpp"
#include "io/zip.hpp"

namespace surfaced {
namespace {

using io::ByteSource;
using io::starts_with;

/// Enough of a file to tell its format: text may begin with comments.
constexpr std::size_t kSniffed = std::size_t{16} << 10;
constexpr std::string_view kDracoMagic = "DRACO";

/// A GLB, or text that begins with an object.
bool looks_like_gltf(std::span<const std::byte> bytes) {
  const auto blank = [](std::byte b) {
    return b == std::byte{' '} || b == std::byte{'\t'} || b == std::byte{'\n'} || b == std::byte{'\r'};
  };
  const auto first = std::ranges::find_if_not(bytes, blank);
  return starts_with(bytes, "glTF") || (first != bytes.end() && *first == std::byte{'{'});
}

/// Bytes that no text has.
bool looks_binary(std::string_view text) {
  return std::ranges::any_of(text,
                             [](char c) { return (c >= 0 && c < 9) || (c > 13 && c < 32 && c != 26 && c != 27); });
}

/// What a file is, by its first bytes.
enum class Kind : std::uint8_t { ply, draco, las, gltf, stl, pcd, obj, gzip, zip, utf16, text, unknown };

std::string_view format_name(Kind kind) {
  constexpr std::array<std::string_view, 12> kNames{"PLY", "Draco", "LAS", "glTF",   "STL",  "PCD",
                                                    "OBJ", "gzip",  "ZIP", "UTF-16", "text", "?"};
  return kNames.at(static_cast<std::size_t>(kind));
}

/// The start as text.
std::string_view text_at(ByteSource& source) {
  const std::span<const std::byte> start = source.peek(kSniffed);
  return io::text_of(start).substr(0, kSniffed);
}

/// Skips the byte order mark that some programs write before text.
void skip_mark(ByteSource& source) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (starts_with(source.peek(kSniffed), kMark)) source.advance(kMark.size());
}

/// @param stl  set where the kind is stl.
Kind kind_of(ByteSource& source, std::optional<io::StlKind>& stl) {
  const std::span<const std::byte> start = source.peek(kSniffed);
  if (io::looks_like_ply(start)) return Kind::ply;
  if (starts_with(start, kDracoMagic)) return Kind::draco;
  if (starts_with(start, "LASF")) return Kind::las;
  if (starts_with(start, "glTF")) return Kind::gltf;
  if (io::looks_like_gzip(start)) return Kind::gzip;
  if (io::looks_like_zip(start)) return Kind::zip;
  stl = io::stl_kind_of(start, source.remaining());
  if (stl) return Kind::stl;
  if (io::looks_like_utf16(start)) return Kind::utf16;
  if (io::stranger_in(start.first(std::min(start.size(), kSniffed)))) return Kind::unknown;
  if (looks_like_gltf(start)) return Kind::gltf;
  const std::string_view text = text_at(source);
  if (io::looks_like_pcd(text)) return Kind::pcd;
  if (io::looks_like_obj(text)) return Kind::obj;
  return looks_binary(text) ? Kind::unknown : Kind::text;
}

Error unknown_format(ByteSource& source, std::string_view name) {
  const std::span<const std::byte> start = source.peek(kSniffed);
  const auto stranger = io::stranger_in(start.first(std::min(start.size(), kSniffed)));
  return {ErrorCode::unknown_format,
          std::string(name) + (stranger ? " is " + *stranger
                                        : " is in no format that is read here; it begins with " + io::shown(start))};
}

Result<RawCloud> read_as(Kind kind, std::optional<io::StlKind> stl, ByteSource& source, std::string_view name,
                         const ReadOptions& options, const io::Beside& beside) {
  switch (kind) {
    case Kind::ply:
      return io::read_ply_cloud(source, name, options);
    case Kind::draco:
      return io::read_draco_cloud(source.rest(), name, options.limits);
    case Kind::las:
      return io::read_las_cloud(source, name, options);
    case Kind::gltf:
      return io::read_gltf_cloud(source.rest(), name, options.limits, beside);
    case Kind::stl:
      return io::read_stl_cloud(source, name, *stl, options.limits);
    case Kind::pcd:
      return io::read_pcd_cloud(source, name, options.limits);
    case Kind::obj:
      return io::read_obj_cloud(source, name, options.limits);
    default:
      break;
  }
  return io::read_text_cloud(source, name, options);
}

bool is_wrapping(Kind kind) { return kind == Kind::gzip || kind == Kind::zip || kind == Kind::utf16; }

/// Takes a file out of what it is wrapped in. `beside` is set where an archive holds other files too.
Result<io::Unwrapped> unwrap(Kind kind, std::span<const std::byte> bytes, std::string_view name, io::Beside& beside) {
  if (kind == Kind::utf16) return io::Unwrapped{{}, io::utf8_of_utf16(bytes)};
  if (kind == Kind::zip) {
    Result<io::Unwrapped> inner = io::cloud_in_zip(bytes, name);
    if (inner) beside = io::beside_in_zip(bytes, name, inner->name);
    return inner;
  }
  Result<io::Bytes> inner = io::gunzipped(bytes, name);
  if (!inner) return std::move(inner).error();
  return io::Unwrapped{{}, std::move(*inner)};
}

/// A file within a file is read; a third is not.
Error wrapped_too_often(std::string_view name, Kind kind) {
  return {ErrorCode::unsupported_feature, std::string(name) + ": within its wrapping there is " +
                                              std::string(format_name(kind)) + " again; unpack it first"};
}

/// Calls read(kind, stl, source, name, beside) on what is within the file, past gzip, ZIP and UTF-16.
template <class T, class Read>
Result<T> within(ByteSource& source, std::string_view name, io::Beside beside, int depth, Read read) {
  skip_mark(source);
  if (source.failure()) return *source.failure();
  if (source.peek(1).empty()) return Error{ErrorCode::empty_input, std::string(name) + " has 0 bytes"};
  std::optional<io::StlKind> stl;
  const Kind kind = kind_of(source, stl);
  if (!is_wrapping(kind)) return read(kind, stl, source, name, beside);
  // UTF-16 may stand within an archive.
  if (depth == 2 || (depth == 1 && kind != Kind::utf16)) return wrapped_too_often(name, kind);
  const std::span<const std::byte> bytes = source.rest();
  if (source.failure()) return *source.failure();
  const Result<io::Unwrapped> inner = unwrap(kind, bytes, name, beside);
  if (!inner) return inner.error();
  ByteSource unwrapped(inner->bytes);
  const std::string called = inner->name.empty() ? std::string(name) : std::string(name) + "/" + inner->name;
  return within<T>(unwrapped, called, beside, depth + 1, read);
}

/// What was left of a mesh that was sent as a cloud.
void warn_of_faces(RawCloud& cloud) {
  if (cloud.source.faces == 0) return;
  cloud.warnings.push_back(
      "the file is a mesh of " + std::to_string(cloud.source.faces) +
      " faces, which are left aside: its vertices are taken as points; input=mesh keeps the faces");
}

Result<RawCloud> cloud_of_3mf(std::span<const std::byte> bytes, std::string_view name, const ReadLimits& limits) {
  RawCloud cloud;
  Result<TriangleMesh> mesh = io::read_3mf_mesh(bytes, name, cloud.warnings);
  if (!mesh) return std::move(mesh).error();
  if (mesh->positions.size() > io::most_points(limits)) {
    return io::too_many(name, mesh->positions.size(), io::most_points(limits));
  }
  cloud.positions = std::move(mesh->positions);
  cloud.source = {.format = "3MF", .table = {}, .faces = mesh->triangles.size()};
  return cloud;
}

/// An archive that holds a model of 3MF.
bool is_3mf(ByteSource& source, std::string_view name) {
  if (!io::looks_like_zip(source.peek(kSniffed))) return false;
  const auto members = io::zip_directory(source.rest(), name);
  return members && std::ranges::any_of(*members, [](const io::ZipMember& m) { return m.name.ends_with(".model"); });
}

Result<RawCloud> parse(ByteSource& source, std::string_view name, const ReadOptions& options, io::Beside beside) {
  Result<RawCloud> cloud =
      is_3mf(source, name)
          ? cloud_of_3mf(source.rest(), name, options.limits)
          : within<RawCloud>(source, name, std::move(beside), 0,
                             [&](Kind kind, std::optional<io::StlKind> stl, ByteSource& inner, std::string_view called,
                                 const io::Beside& files) -> Result<RawCloud> {
                               const bool table = !options.table.columns.empty();
                               if (kind == Kind::unknown && !table) return unknown_format(inner, called);
                               if (kind == Kind::unknown) kind = Kind::text;
                               Result<RawCloud> read = read_as(kind, stl, inner, called, options, files);
                               if (read) read->source.format = format_name(kind);
                               return read;
                             });
  if (cloud) warn_of_faces(*cloud);
  return cloud;
}

Result<TriangleMesh> parse_mesh(ByteSource& source, std::string_view name, std::vector<std::string>* warnings,
                                io::Beside beside) {
  std::vector<std::string> unheard;
  std::vector<std::string>& heard = warnings == nullptr ? unheard : *warnings;
  if (is_3mf(source, name)) return io::read_3mf_mesh(source.rest(), name, heard);
  return within<TriangleMesh>(source, name, std::move(beside), 0,
                              [&](Kind kind, std::optional<io::StlKind> stl, ByteSource& inner, std::string_view called,
                                  const io::Beside& files) -> Result<TriangleMesh> {
                                if (kind == Kind::ply) return io::read_ply_mesh(inner, called, heard);
                                if (kind == Kind::draco) return io::read_draco_mesh(inner.rest(), called, {}, heard);
                                if (kind == Kind::gltf) return io::read_gltf_mesh(inner.rest(), called, heard, files);
                                if (kind == Kind::stl) return io::read_stl_mesh(inner, called, *stl, heard);
                                if (kind == Kind::obj) return io::read_obj_mesh(inner, called, heard);
                                if (kind == Kind::unknown || (kind == Kind::text && !io::looks_like_table(inner))) {
                                  return unknown_format(inner, called);
                                }
                                return Error{ErrorCode::unsupported_feature,
                                             std::string(called) + " is " + std::string(format_name(kind)) +
                                                 ", which holds points and no triangles: reconstruct it with "
                                                 "input=cloud, or give a mesh in PLY, GLB, glTF, "
                                                 "Draco, OBJ, STL or 3MF"};
                              });
}

/// The files beside one that is read by its path, where they may be read too.
io::Beside files_beside(const std::filesystem::path& path, const ReadOptions& options) {
  return options.files_beside ? io::beside_in_folder(path.parent_path()) : io::Beside();
}

}  // namespace

Result<RawCloud> read_cloud(const std::filesystem::path& path, const ReadOptions& options, std::string_view name) {
  const std::string called = name.empty() ? path.filename().string() : std::string(name);
  return io::guarded<RawCloud>(called, [&]() -> Result<RawCloud> {
    Result<ByteSource> source = ByteSource::open(path);
    if (!source) return std::move(source).error();
    return parse(*source, called, options, files_beside(path, options));
  });
}

Result<RawCloud> parse_cloud(std::span<const std::byte> bytes, std::string_view name, const ReadOptions& options) {
  return io::guarded<RawCloud>(name, [&] {
    ByteSource source(bytes);
    return parse(source, name, options, {});
  });
}

Result<TriangleMesh> decode_mesh(std::span<const std::byte> bytes, std::string_view name,
                                 std::vector<std::string>* warnings) {
  return io::guarded<TriangleMesh>(name, [&] {
    ByteSource source(bytes);
    return parse_mesh(source, name, warnings, {});
  });
}

Result<TriangleMesh> read_mesh(const std::filesystem::path& path, std::vector<std::string>* warnings,
                               const ReadOptions& options, std::string_view name) {
  const std::string called = name.empty() ? path.filename().string() : std::string(name);
  return io::guarded<TriangleMesh>(called, [&]() -> Result<TriangleMesh> {
    Result<ByteSource> source = ByteSource::open(path);
    if (!source) return std::move(source).error();
    return parse_mesh(*source, called, warnings, files_beside(path, options));
  });
}

}  // namespace surfaced
