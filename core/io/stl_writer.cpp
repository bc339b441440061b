// SPDX-License-Identifier: GPL-3.0-or-later
// Binary STL. Its float32 coordinates are relative to an origin where they would lose digits otherwise
// (stl_binary.hpp).
#include <algorithm>
#include <cmath>

#include "io/formats.hpp"
#include "io/scalars.hpp"
#include "io/stl_binary.hpp"

namespace surfaced::io {
namespace {

std::array<float, 3> unit_normal(const std::array<std::array<float, 3>, 3>& c) {
  const auto wide = [](const std::array<float, 3>& p) { return Point3{p[0], p[1], p[2]}; };
  const Point3 n = cross(wide(c[1]) - wide(c[0]), wide(c[2]) - wide(c[0]));
  const double length = norm(n);
  if (!(length > 0) || !std::isfinite(length)) return {0, 0, 0};  // STL's sign for: compute it from the corners
  return {static_cast<float>(n[0] / length), static_cast<float>(n[1] / length), static_cast<float>(n[2] / length)};
}

}  // namespace

Result<Bytes> write_stl_mesh(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return Error{ErrorCode::method_failed, "the mesh has no triangles; STL cannot hold that"};
  if (mesh.triangles.size() > 0xFFFFFFFFU) {
    return Error{ErrorCode::output_not_writable,
                 std::to_string(mesh.triangles.size()) + " triangles; STL holds at most 4294967295"};
  }
  Point3 origin = float_origin_of(mesh.positions);
  std::string header = origin == Point3{} ? "surfaced " SURFACED_VERSION : stl_origin_text(origin);
  if (header.size() > kStlHeader) {
    origin = {};
    header = "surfaced " SURFACED_VERSION;
  }
  header.resize(kStlHeader, ' ');
  Bytes bytes = bytes_of_text(header);
  bytes.reserve(kStlHeader + 4 + kStlFacet * mesh.triangles.size());
  append_little(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    std::array<std::array<float, 3>, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) corners.at(k) = local_position(mesh.positions[t[k]], origin);
    for (const float x : unit_normal(corners)) append_little(bytes, x);
    for (const auto& corner : corners) {
      for (const float x : corner) append_little(bytes, x);
    }
    append_little(bytes, std::uint16_t{0});
  }
  return bytes;
}

}  // namespace surfaced::io
