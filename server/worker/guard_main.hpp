// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "worker/child_process.hpp"

namespace surfaced {

/// Word that stands before the command of a child that is to be run under guard.
inline constexpr const char* kGuardCommand = "guard";

/// A process between the server and the child of an attempt: it watches the child as the server would, and tells the
/// server what comes of it. Whatever the child's end does to the process that watches it happens to this one, and the
/// server lives to count it against the input. For inputs under which a server has died before.
/// @param command      of the child, without its description
/// @param description  of the attempt
/// @return  the exit code of the process
int guard_main(std::vector<std::string> command, const std::string& description,
               ChildProcess::Namespaces namespaces = ChildProcess::Namespaces::its_own);

}  // namespace surfaced
