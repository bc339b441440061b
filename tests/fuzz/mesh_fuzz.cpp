// Meshes of every format; what was read must survive being written and read again.
#include <array>
#include <cmath>

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

void check_round_trip(const TriangleMesh& mesh, MeshFormat format) {
  const Result<std::vector<std::byte>> encoded = encode_mesh(mesh, format);
  if (!encoded) {  // a mesh without triangles, or with coordinates that no format holds
    check_error(encoded.error());
    return;
  }
  const Result<TriangleMesh> again = decode_mesh(*encoded, "again");
  demand(again.ok(), "what was written can be read");
  demand(again->triangles == mesh.triangles, "triangles survive being written and read");
  demand(again->positions.size() == mesh.positions.size(), "vertices survive being written and read");
  if (fits_float(mesh)) demand(again->positions == mesh.positions, "float32 coordinates are kept bit for bit");
  demand(again->colors == mesh.colors, "colours survive being written and read");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Result<TriangleMesh> mesh = decode_mesh(as_bytes(data, size), "fuzz");
  if (!mesh) {
    check_error(mesh.error());
    return 0;
  }
  check_mesh(*mesh);
  for (const MeshFormat format : {MeshFormat::glb, MeshFormat::gltf, MeshFormat::drc, MeshFormat::ply}) {
    check_round_trip(*mesh, format);
  }
  return 0;
}
