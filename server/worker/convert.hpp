// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "worker/attempt_protocol.hpp"

namespace surfaced {

/// Encodes a mesh that a job has made in another format, by the extension of the output's name; to be called in a
/// child. The mesh is read from its file, so that all formats hold the same vertices.
/// @param report  of the job, for the extras of a glTF: without what differs from run to run; null for none
Status convert_mesh(const std::filesystem::path& mesh, const std::filesystem::path& output,
                    const nlohmann::ordered_json& parameters, nlohmann::ordered_json report);

}  // namespace surfaced
