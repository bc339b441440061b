// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/base.hpp"

namespace surfaced {

/// Prints the error as one JSON problem (RFC 9457 fields that make sense without HTTP) on stderr.
/// @return  the exit code that belongs to it.
int report_problem(const Error& error);

}  // namespace surfaced
