// SPDX-License-Identifier: GPL-3.0-or-later
// Draco's decoders behind a guard: what a file declares is weighed against its size before Draco
// allocates or loops for it.
#pragma once

#include <draco/mesh/mesh.h>
#include <draco/point_cloud/point_cloud.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "base/base.hpp"

namespace surfaced::io {

/// A decoded file; `mesh` is the same object where the file holds one, else null.
struct DracoGeometry {
  std::unique_ptr<draco::PointCloud> points;
  const draco::Mesh* mesh = nullptr;
};

/// Decodes a cloud or mesh of any encoding Draco knows.
/// @return  the geometry with at least one point; truncated_input, malformed_input, unsupported_feature,
///          too_many_points, empty_input. Indices and sizes of attributes are still to be checked.
/// @cost    about 160 MiB of memory at most, and a KiB for every byte of the file beyond a MiB.
Result<DracoGeometry> decode_draco(std::span<const std::byte> bytes, std::string_view name, std::uint64_t max_points);

}  // namespace surfaced::io
