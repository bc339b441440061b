// SPDX-License-Identifier: GPL-3.0-or-later
// What was wrong with a command line, in the form that all errors have.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <span>

#include "base/base.hpp"

namespace surfaced {

/// Gives every command that has none the flag --json (SURFACED_JSON): errors as JSON.
void add_json_flags(CLI::App& app);

/// Whether --json stands among the words, understood or not, or SURFACED_JSON is set.
bool asks_for_json(std::span<char* const> words);

/// Reports invalid_usage with the flag or command at fault, its value, what is allowed, the nearest name, and how the
/// command is called.
/// @return  the exit code.
int report_usage(const CLI::App& app, const CLI::ParseError& wrong, std::span<char* const> words);

/// A path as it was given, and the argument that it was given for.
struct GivenPath {
  const char* argument;
  std::filesystem::path path;
};

/// Reports the error of a command that reads and writes files: of one that is not there the nearest name in its folder,
/// of a folder that is not there how it is made.
/// @return  the exit code.
int report_file_problem(Error error, std::span<const GivenPath> inputs, const GivenPath& output);

}  // namespace surfaced
