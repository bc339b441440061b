// SPDX-License-Identifier: GPL-3.0-or-later
// Packs the buffer of a glTF that is about to be written.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "io/formats.hpp"

namespace surfaced::io {

/// An array of the buffer: bufferView i and accessor i are array i. The first holds positions, the last indices.
struct GltfArray {
  std::size_t offset = 0;
  std::size_t count = 0;
  std::size_t stride = 0;
};

/// A glTF whose one buffer is written raw so far.
struct GltfParts {
  nlohmann::ordered_json json;
  Bytes buffer;
  std::vector<GltfArray> arrays;
};

/// EXT_meshopt_compression of every array; with `bits` the positions lose all but that many.
void pack_with_meshopt(GltfParts& parts, const std::vector<Triangle>& triangles, const std::optional<int>& bits);

/// KHR_draco_mesh_compression of the primitive. `mesh` as it stands in the buffer.
Status pack_with_draco(GltfParts& parts, const TriangleMesh& mesh, const EncodeOptions& options);

}  // namespace surfaced::io
