// SPDX-License-Identifier: GPL-3.0-or-later
// The outputs that a job can have: their names, media types, and what else clients call those.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced::api {

struct OutputKind {
  std::string_view name;
  std::string_view media_type;
  /// Unregistered names under which clients ask for it, separated by spaces.
  std::string_view aliases;
};

/// The formats of the mesh, the default one first.
std::span<const OutputKind> mesh_kinds();

bool is_mesh(std::string_view output);

/// Media type of an output by its name; empty if no client sees an output of that name.
std::string_view media_type_of(std::string_view output);

/// The outputs of a job that asks for these: the meshes in their order (mesh.glb if none is named), then cloud.ply if
/// it is named, report.json and log.txt. unknown_output for a name that is none, or that the method does not make.
Result<std::vector<std::string>> outputs_for(std::span<const std::string> names, const MethodInfo& method);

/// mesh.ply for `ply`; unknown_output.
Result<std::string> mesh_named(std::string_view format);

/// The mesh that an Accept header wants most.
/// @param accept   none for anything
/// @param made     outputs that are there already; among equals they come first
/// @return  not_acceptable, naming the media types there are
Result<std::string> negotiate_mesh(std::optional<std::string_view> accept, std::span<const std::string> made);

}  // namespace surfaced::api
