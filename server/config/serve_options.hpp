#pragma once

#include <CLI/CLI.hpp>

#include "config/settings.hpp"

namespace surfaced {

/// Gives the command a flag and an environment variable (SURFACED_...) for every setting, with its unit,
/// its default and what is allowed.
void add_serve_options(CLI::App& command, Settings& settings);

}  // namespace surfaced
