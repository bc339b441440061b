// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "base/base.hpp"

namespace surfaced {

/// How errors are told: as one line of JSON, or as text for people.
enum class ProblemFormat : std::uint8_t { text, json };

/// Text if standard error is a terminal, until this says otherwise (--json).
void set_problem_format(ProblemFormat format);

/// Prints the error on standard error: what, where, the value, what is allowed, a hint and the code; or as one JSON
/// problem (RFC 9457 fields that make sense without HTTP).
/// @param hint  what to do, where more is known than error and code tell; else the nearest name and the code's hint.
/// @return      the exit code that belongs to it.
int report_problem(const Error& error, const std::string& hint = {});

/// Several of one code, each on lines of its own; as JSON one problem whose detail names all.
int report_problems(std::span<const Error> errors);

}  // namespace surfaced
