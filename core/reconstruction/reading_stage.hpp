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

/// A cloud from a file.
/// @param name  what messages call it; empty: its file name.
Result<PointCloud> load_cloud(const std::filesystem::path& path, const ReadOptions& options, Missing missing,
                              std::string_view name, Context& context);

/// What may spoil a reconstruction although every point is read right, a sentence each: steps of float32; near-repeats
/// that the parameters do not fuse.
std::vector<std::string> doubts_of(const PointCloud& cloud, const Json& parameters, Context& context);

/// A mesh from a file, and its vertices as a cloud.
struct LoadedMesh {
  TriangleMesh mesh;
  PointCloud cloud;
};
Result<LoadedMesh> load_mesh(const std::filesystem::path& path, const ReadOptions& options, std::string_view name,
                             Context& context);

}  // namespace surfaced
