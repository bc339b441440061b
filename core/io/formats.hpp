// SPDX-License-Identifier: GPL-3.0-or-later
// The formats behind io.hpp: one reader and one writer each.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/float32.hpp"
#include "io/bytes.hpp"
#include "io/io.hpp"

namespace surfaced::io {

using Bytes = std::vector<std::byte>;

/// Readers of a format may throw bad_alloc and length_error; io.cpp, the room's wall, catches them.
Result<RawCloud> read_ply_cloud(ByteSource& source, std::string_view name, const ReadOptions& options);
Result<TriangleMesh> read_ply_mesh(ByteSource& source, std::string_view name, std::vector<std::string>& warnings);
/// Files that a glTF names, by their relative paths; none where only the file itself may be read.
using Beside = std::function<Result<Bytes>(const std::string& path)>;
Result<TriangleMesh> read_gltf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                    std::vector<std::string>& warnings, const Beside& beside);

/// Unique ids of the attributes of a Draco file, as a glTF names them.
struct DracoIds {
  std::optional<std::uint32_t> position;
  std::optional<std::uint32_t> normal;
  std::optional<std::uint32_t> color;
};

Result<RawCloud> read_draco_cloud(std::span<const std::byte> bytes, std::string_view name, const ReadLimits& limits);
/// Without ids the attributes are told by their types.
Result<TriangleMesh> read_draco_mesh(std::span<const std::byte> bytes, std::string_view name,
                                     const std::optional<DracoIds>& ids, std::vector<std::string>& warnings);

Result<RawCloud> read_gltf_cloud(std::span<const std::byte> bytes, std::string_view name, const ReadLimits& limits,
                                 const Beside& beside);
Result<RawCloud> read_las_cloud(ByteSource& source, std::string_view name, const ReadOptions& options);
Result<RawCloud> read_pcd_cloud(ByteSource& source, std::string_view name, const ReadLimits& limits);
Result<RawCloud> read_obj_cloud(ByteSource& source, std::string_view name, const ReadLimits& limits);
Result<TriangleMesh> read_obj_mesh(ByteSource& source, std::string_view name, std::vector<std::string>& warnings);
/// Whether text has rows of numbers, whatever else is wrong with it.
bool looks_like_table(ByteSource& source);
Result<RawCloud> read_text_cloud(ByteSource& source, std::string_view name, const ReadOptions& options);

/// STL has no magic: a binary file is told by its length, or by zeros among the first bytes after 'solid'.
enum class StlKind : std::uint8_t { ascii, binary };
std::optional<StlKind> stl_kind_of(std::span<const std::byte> start, std::uint64_t size);
Result<RawCloud> read_stl_cloud(ByteSource& source, std::string_view name, StlKind kind, const ReadLimits& limits);
/// Vertices of the same position are one, numbered in the order in which the facets name them.
Result<TriangleMesh> read_stl_mesh(ByteSource& source, std::string_view name, StlKind kind,
                                   std::vector<std::string>& warnings);

/// Whether text begins as these formats do.
bool looks_like_pcd(std::string_view start);
bool looks_like_obj(std::string_view start);

/// The limit on points, and the error of a file that has more.
std::uint64_t most_points(const ReadLimits& limits);
Error too_many(std::string_view name, std::uint64_t points, std::uint64_t limit);

/// Triangles with a repeated vertex are left out by every reader, which says so.
void warn_of_degenerate(std::size_t triangles, std::vector<std::string>& warnings);

Result<Bytes> write_ply_mesh(const TriangleMesh& mesh, const std::vector<VertexScalar>& scalars);
/// Draco's id of an attribute is its place among positions, normals (if there are), colours (if there are), scalars.
Result<Bytes> write_draco(const TriangleMesh& mesh, const std::optional<int>& quantization_bits,
                          const std::vector<VertexScalar>& scalars = {});
Result<Bytes> write_gltf(const TriangleMesh& mesh, MeshFormat format, const EncodeOptions& options);

Result<Bytes> write_obj_mesh(const TriangleMesh& mesh);
Result<Bytes> write_stl_mesh(const TriangleMesh& mesh);
Result<Bytes> write_3mf_mesh(const TriangleMesh& mesh, const EncodeOptions& options);
Result<TriangleMesh> read_3mf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                   std::vector<std::string>& warnings);

/// What is subtracted from the coordinates: nothing if float32 holds them, else the middle of the mesh
/// rounded to a multiple of a power of two near its size. So it has few digits, is itself held by
/// float32 wherever the mesh is not absurdly far away, and the subtraction is exact.
Point3 float_origin_of(const std::vector<Point3>& positions);
std::array<float, 3> local_position(const Point3& position, const Point3& origin);

Bytes bytes_of_text(const std::string& text);

}  // namespace surfaced::io
