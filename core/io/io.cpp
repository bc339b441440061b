// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/io.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/text.hpp"
#include "io/formats.hpp"
#include "io/guarded.hpp"

namespace surfaced {
namespace {

using io::guarded;

constexpr auto kExtensions = std::to_array<std::pair<std::string_view, MeshFormat>>({
    {".glb", MeshFormat::glb},
    {".gltf", MeshFormat::gltf},
    {".drc", MeshFormat::drc},
    {".ply", MeshFormat::ply},
    {".obj", MeshFormat::obj},
    {".stl", MeshFormat::stl},
    {".3mf", MeshFormat::threemf},
});

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

Result<MeshFormat> mesh_format_of(const std::filesystem::path& path) {
  const std::string extension = in_lower_case(path.extension().string());
  const auto* found =
      std::ranges::find(kExtensions, std::string_view(extension), [](const auto& row) { return row.first; });
  if (found != kExtensions.end()) return found->second;
  const std::string known = joined(kExtensions, ", ", [](const auto& row) { return row.first; });
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

}  // namespace surfaced
