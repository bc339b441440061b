// SPDX-License-Identifier: GPL-3.0-or-later
// The commands of the binary. Each adds itself to the command line; `run` is set to what shall be
// done once the line has been understood.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace surfaced {

/// What the chosen command does; returns the exit code of the process.
using Run = std::function<int()>;

void add_reconstruct(CLI::App& app, Run& run);
void add_measure(CLI::App& app, Run& run);
void add_methods(CLI::App& app, Run& run);
void add_serve(CLI::App& app, Run& run);
void add_check_config(CLI::App& app, Run& run);
void add_keys(CLI::App& app, Run& run);
void add_backup(CLI::App& app, Run& run);
/// Hidden: what the server starts for every attempt at a job.
void add_attempt(CLI::App& app, Run& run);
/// Hidden: what the server starts to look at a stored cloud, and to encode a mesh anew.
void add_side_tasks(CLI::App& app, Run& run);

}  // namespace surfaced
