// SPDX-License-Identifier: GPL-3.0-or-later
// What every child of the server does around its work.
#pragma once

#include <functional>
#include <string>

#include "base/error.hpp"
#include "worker/attempt_protocol.hpp"

namespace surfaced {

/// Sends a message up the pipe. Nobody is left to tell if this fails: then the server is gone, and its death is this
/// process's.
void tell_server(const std::string& message);

/// Reads the description of the attempt, confines this process as it says, and does the work. What goes wrong is told
/// to the server and on standard error. Returns the exit code.
int run_confined(const std::string& description, const std::function<Status(const AttemptSpec&)>& work);

}  // namespace surfaced
