// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "worker/attempt_protocol.hpp"

namespace surfaced {

/// True in the process that start_contained has started.
bool is_first_process();

/// Hides all files but the attempt's, and starts the process that is to do the work; it alone returns from here. The
/// first process, whom signals do not end as they end others, waits for it and ends with what it ended with.
/// @return  what is in force, for the log
Result<std::string> continue_behind_first_process(const AttemptSpec& spec);

}  // namespace surfaced
