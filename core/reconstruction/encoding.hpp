// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: what becomes of a mesh in a file.
#pragma once

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// What the encoding did to the vertices, which keep their order.
struct EncodingEffect {
  double max_error = 0;
  std::size_t merged_vertices = 0;
  /// Of the file as readers see it that join vertices by position, triangles that fell together with an edge left out;
  /// none if that is what it is by index, too.
  std::optional<Topology> by_position = std::nullopt;
  /// Pairs of crossing triangles more than before; none unless positions were quantised.
  std::optional<std::size_t> crossings_made = std::nullopt;
  /// The least bits per coordinate, from those asked for, that change neither; none if these do not, or no bits do.
  std::optional<int> least_bits = std::nullopt;
};

/// Compares a mesh with what was decoded of its file. An STL has no vertices, only corners: there the vertices are
/// compared with what the file holds of each.
/// @return  internal_error if the decoded mesh has other vertices; cancelled.
/// @cost    O(V + F); with quantised positions O(F log F) for the crossings, and where there are any an encoding more
///          for each number of bits that is tried.
Result<EncodingEffect> effect_of_encoding(const TriangleMesh& computed, const TriangleMesh& decoded, MeshFormat format,
                                          const EncodeOptions& options, Context& context);

/// What to say of the encoding, beside what is said of the mesh.
std::vector<std::string> encoding_warnings(const EncodingEffect& effect);

/// A warning for each parameter that asks for a smaller file and that this format does not heed.
std::vector<std::string> unheeded_packing(MeshFormat format, const Json& parameters);

/// The report's section `encoding`.
Json encoding_json(const EncodingEffect& effect, MeshFormat format, const Json& parameters);

}  // namespace surfaced
