// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace surfaced {

/// The child's side of an attempt: the only place of the service where the bytes of a cloud are parsed.
/// Confines itself, reconstructs, writes the mesh and report.json into the attempt's directory, reports
/// progress and problems on descriptor 3, and says on standard error what belongs into log.txt.
/// @param description  what the server encoded
/// @return  the exit code of the process.
int attempt_main(const std::string& description);

}  // namespace surfaced
