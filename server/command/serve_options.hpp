// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include "config/configuration.hpp"

namespace surfaced {

/// Gives the command a flag for every setting, with its unit, its default, what is allowed and its variable, and
/// --config FILE. What is given is put into `sources` when the line is parsed.
void add_setting_flags(CLI::App& command, Sources& sources);

/// The variables of this process; SURFACED_CONFIG names the file if no flag does.
void use_environment(Sources& sources);

}  // namespace surfaced
