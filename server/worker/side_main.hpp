// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace surfaced {

/// Names of the commands that the server starts for them.
inline constexpr const char* kInspectCommand = "inspect-cloud";
inline constexpr const char* kConvertCommand = "convert-mesh";

/// The children of side tasks, after the process was started; each returns the exit code.

/// Reads a cloud and writes what it is: points, distinct points, bounds, attributes, warnings.
int inspect_main(const std::string& description);

/// Reads a mesh that was made by a job and writes it in the format of the output's name.
int convert_main(const std::string& description);

}  // namespace surfaced
