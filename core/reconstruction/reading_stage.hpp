// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: what comes before a method's stages: a file as the parameters want it read.
#pragma once

#include <filesystem>
#include <string_view>

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// Schemas of the parameters of this file, for every method.
Json reading_properties();

/// Whether the file is a mesh to be kept, so that no method runs.
bool asks_for_mesh(const Json& parameters);

/// How the parameters want a file read.
ReadOptions read_options_of(const Json& parameters, const ReadLimits& limits, bool files_beside);

/// A cloud from a file, with warnings of what a user should know of it before anything is made of it.
/// @param name  what messages call it; empty: its file name.
Result<PointCloud> load_cloud(const std::filesystem::path& path, const ReadOptions& options, Missing missing,
                              std::string_view name, Context& context);

/// A mesh from a file, and its vertices as a cloud.
struct LoadedMesh {
  TriangleMesh mesh;
  PointCloud cloud;
};
Result<LoadedMesh> load_mesh(const std::filesystem::path& path, const ReadOptions& options, std::string_view name,
                             Context& context);

}  // namespace surfaced
