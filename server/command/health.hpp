// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "command/command.hpp"

namespace surfaced {

/// `surfaced health`: asks the server on this machine for its /readyz; for containers, which have no curl.
void add_health(CLI::App& app, Run& run);

}  // namespace surfaced
