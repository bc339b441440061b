// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes of every format; what was read must survive being written and read again.
#include <array>
#include <cmath>
#include <optional>

#include "fuzz/fuzz_input.hpp"

namespace {

using namespace surfaced;
using namespace surfaced::testing;

bool fits_float(const TriangleMesh& mesh) {
  for (const Point3& p : mesh.positions) {
    for (const double x : p) {
      if (static_cast<double>(static_cast<float>(x)) != x) return false;
    }
  }
  return true;
}

/// Writes the mesh and reads it again; none if the format cannot hold it.
std::optional<TriangleMesh> written_and_read(const TriangleMesh& mesh, MeshFormat format,
                                             MeshCompression compression = MeshCompression::none) {
  EncodeOptions options;
  options.compression = compression;
  const Result<std::vector<std::byte>> encoded = encode_mesh(mesh, format, options);
  if (!encoded) {  // a mesh without triangles, or with coordinates that no format holds
    check_error(encoded.error());
    return std::nullopt;
  }
  Result<TriangleMesh> again = decode_mesh(*encoded, "again");
  demand(again.ok(), "what was written can be read");
  return std::move(*again);
}

void check_vertices(const TriangleMesh& mesh, const TriangleMesh& again) {
  demand(again.positions.size() == mesh.positions.size(), "vertices survive being written and read");
  if (fits_float(mesh)) demand(again.positions == mesh.positions, "float32 coordinates are kept bit for bit");
}

void check_round_trip(const TriangleMesh& mesh, MeshFormat format) {
  const std::optional<TriangleMesh> again = written_and_read(mesh, format);
  if (!again) return;
  check_vertices(mesh, *again);
  demand(again->triangles == mesh.triangles, "triangles survive being written and read");
  const bool colored = format != MeshFormat::obj && format != MeshFormat::threemf;
  if (colored) demand(again->colors == mesh.colors, "colours survive being written and read");
  if (format == MeshFormat::obj) demand(again->positions == mesh.positions, "an OBJ keeps doubles");
}

void check_packed(TriangleMesh mesh, MeshCompression compression) {
  std::optional<TriangleMesh> again = written_and_read(mesh, MeshFormat::glb, compression);
  if (!again) return;
  check_vertices(mesh, *again);
  sort_triangles(mesh);
  sort_triangles(*again);
  demand(again->triangles == mesh.triangles, "triangles survive being packed, but for their first corner");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Result<TriangleMesh> mesh = decode_mesh(as_bytes(data, size), "fuzz");
  if (!mesh) {
    check_error(mesh.error());
    return 0;
  }
  check_mesh(*mesh);
  for (const MeshFormat format :
       {MeshFormat::glb, MeshFormat::gltf, MeshFormat::drc, MeshFormat::ply, MeshFormat::obj, MeshFormat::threemf}) {
    check_round_trip(*mesh, format);
  }
  for (const MeshCompression compression : {MeshCompression::draco, MeshCompression::meshopt}) {
    check_packed(*mesh, compression);
  }
  // Vertices of one place become one in an STL, and so may triangles vanish.
  if (const std::optional<TriangleMesh> again = written_and_read(*mesh, MeshFormat::stl)) {
    demand(again->triangles.size() <= mesh->triangles.size(), "an STL has no more triangles than the mesh");
  }
  return 0;
}
