// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: what becomes of a mesh in a file.
#pragma once

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// What the encoding did to the vertices, which keep their order.
struct EncodingEffect {
  double max_error = 0;
  std::size_t merged_vertices = 0;
};

/// Compares a mesh with what was decoded of its file. An STL has no vertices, only corners: there the vertices are
/// compared with what the file holds of each.
/// @return  internal_error if the decoded mesh has other vertices.
Result<EncodingEffect> effect_of_encoding(const TriangleMesh& computed, const TriangleMesh& decoded, MeshFormat format);

/// A warning for each parameter that asks for a smaller file and that this format does not heed.
std::vector<std::string> unheeded_packing(MeshFormat format, const Json& parameters);

/// The report's section `encoding`.
Json encoding_json(const EncodingEffect& effect, MeshFormat format, const Json& parameters);

}  // namespace surfaced
