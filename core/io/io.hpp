// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds and meshes as files. Formats are told by content when reading, by extension when writing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "cloud/cloud.hpp"
#include "mesh/mesh.hpp"

namespace surfaced {

/// What a reader may spend on one file.
struct ReadLimits {
  std::uint64_t max_points = 500'000'000;
};

enum class Separator : std::uint8_t { guessed, blank, tab, comma, semicolon, bar };
enum class Decimal : std::uint8_t { guessed, point, comma };

/// How text in rows and columns is to be read; what is not said is guessed (README.md).
struct TableOptions {
  /// x, y, z, nx, ny, nz, r, g, b by column, or - for a column to leave, apart by commas; columns beyond them are left.
  /// Empty: guessed.
  std::string columns;
  Separator separator = Separator::guessed;
  Decimal decimal = Decimal::guessed;
  /// Lines at the beginning that are passed over.
  std::size_t skip = 0;
};

/// Which of the Gaussians of a splat (PLY) are points.
struct SplatOptions {
  /// Those of at least this opacity, 0 to 1.
  std::optional<double> least_opacity;
  /// Those whose longest half-axis is at most this, in units of the file.
  std::optional<double> largest_scale;
};

/// How a cloud is read.
struct ReadOptions {
  ReadOptions() = default;
  ReadOptions(const ReadLimits& most) : limits(most) {}  // NOLINT(google-explicit-constructor): limits alone will do

  ReadLimits limits;
  TableOptions table;
  SplatOptions splats;
  /// LAS: a file that ends before its declared points is read as far as it goes, with a warning.
  bool take_truncated = false;
  /// glTF: buffers may lie in other files beside it.
  bool files_beside = false;
};

/// Reads a point cloud: PLY, Draco, LAS, PCD, glTF, OBJ, STL, 3MF or text (README.md), told by its first bytes, also in
/// gzip or a ZIP archive.
/// Declared counts are checked against the bytes at hand before anything is allocated.
/// @return  the points in file order; input_unreadable, empty_input, unknown_format, malformed_input,
///          truncated_input, missing_positions, unsupported_feature, too_many_points.
/// Coordinates are not judged here (make_cloud does). Messages call the cloud `name`, or without one by its
/// file name.
Result<RawCloud> read_cloud(const std::filesystem::path& path, const ReadOptions& options = {},
                            std::string_view name = {});

/// As read_cloud, from bytes in memory; `name` stands in messages.
Result<RawCloud> parse_cloud(std::span<const std::byte> bytes, std::string_view name, const ReadOptions& options = {});

enum class MeshFormat : std::uint8_t { glb, gltf, drc, ply, obj, stl, threemf };

/// The format's name, as in the extension without its dot.
std::string_view name_of(MeshFormat format);

/// Format by the extension of the path; unknown_output lists the extensions there are.
Result<MeshFormat> mesh_format_of(const std::filesystem::path& path);

/// Which axis of the cloud points up. glTF is Y-up: with z its node is rotated, the vertices stay.
enum class UpAxis : std::uint8_t { y, z };

/// What a coordinate of 1 means; only 3MF says it.
enum class Unit : std::uint8_t { millimetre, centimetre, metre, inch };

/// How a glTF is packed.
enum class MeshCompression : std::uint8_t { none, draco, meshopt };

/// A number for every vertex, under a name that begins with '_', as glTF wants it.
struct VertexScalar {
  std::string name;
  std::vector<float> values;
};

struct EncodeOptions {
  /// Draco and packed glTF: bits per coordinate, 8..30; none keeps float32 exactly. Meshopt keeps at most 24 of them,
  /// beside a common exponent a vertex.
  std::optional<int> quantization_bits;
  UpAxis up = UpAxis::y;
  Unit unit = Unit::millimetre;
  /// glTF: as KHR_draco_mesh_compression or EXT_meshopt_compression, which a reader then has to know.
  MeshCompression compression = MeshCompression::none;
  /// glTF: attributes; PLY: properties, in lower case without the '_'.
  std::vector<VertexScalar> scalars{};
  /// JSON object for `asset.extras` of a glTF; empty for none.
  std::string extras_json;
};

/// Encodes a mesh. Vertex order and triangle order are kept in every format but STL, which has no vertices of its own;
/// meshopt may turn a triangle to begin at another corner.
/// OBJ keeps doubles, and no opacity. STL and 3MF: float32 around an origin as in glTF, which the header or a comment
/// names; neither normals of vertices nor colours. glTF: POSITION as float32, NORMAL, COLOR_0 where known; coordinates
/// that float32 holds are kept bit for bit, otherwise an origin is subtracted that stands in the node's translation
/// and, as double, in `extras.origin` of the node. The same mesh and options give the same bytes.
Result<std::vector<std::byte>> encode_mesh(const TriangleMesh& mesh, MeshFormat format,
                                           const EncodeOptions& options = {});

/// The positions as an STL of the mesh holds them, vertex by vertex: its facets cannot be compared one by one.
std::vector<Point3> positions_in_stl(const TriangleMesh& mesh);

/// Decodes a mesh in any MeshFormat, told by content: what a reader of the file gets. Node transforms
/// other than the `up` rotation are applied, in double; polygons are cut into fans. Triangles with a
/// repeated index are left out, as everything else that is dropped, with a sentence in `warnings`.
/// @return  the mesh, with at least one vertex; errors as of read_cloud.
Result<TriangleMesh> decode_mesh(std::span<const std::byte> bytes, std::string_view name,
                                 std::vector<std::string>* warnings = nullptr);
Result<TriangleMesh> read_mesh(const std::filesystem::path& path, std::vector<std::string>* warnings = nullptr,
                               const ReadOptions& options = {}, std::string_view name = {});

/// Writes a point cloud as binary little-endian PLY: float coordinates where float32 holds all of
/// them exactly, else double.
std::vector<std::byte> encode_cloud_ply(const std::vector<Point3>& positions, const std::vector<Normal3>& normals,
                                        const std::vector<Color4>& colors);

/// Writes bytes so that a reader sees the old file or the whole new one: temporary name, fsync, rename.
Status write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace surfaced
