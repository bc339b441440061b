// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: what happens to a mesh between the method and its encoding.
#pragma once

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// Schemas of the parameters of this file, for every method.
Json finishing_properties();

/// Whether edges are to be collapsed; then vertices are no input points any more.
bool asks_for_simplifying(const Json& parameters);

/// Drops small parts and vertices without triangles, simplifies, colours and sorts, as the parameters ask. Counts stand
/// in `result.finishing`.
/// @return  cancelled, out_of_memory, method_failed.
Status finish(Reconstruction& result, const Json& parameters, Context& context);

/// The report's section `printing`: size, volume and, where asked for, thickness of walls, of which a warning speaks.
/// @param mesh  closed and oriented where `volume` is not null.
Json printing_json(const TriangleMesh& mesh, const Json& volume, const Json& parameters,
                   std::optional<MeshFormat> format, std::vector<std::string>& warnings);

}  // namespace surfaced
