// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace surfaced {

/// The name that somebody who wrote this most likely meant: the one with the fewest edits (letters inserted, deleted,
/// replaced or swapped with their neighbour), at most one in three letters; or else one that has it as a whole word
/// between dashes. The first of equals; empty if none is near.
/// @cost  O(len(written) len(name)) a name; more than 64 letters are never near.
std::string nearest_name(std::string_view written, std::span<const std::string> names);

/// "Did you mean 'x'?", or nothing.
std::string did_you_mean(std::string_view written, std::span<const std::string> names);

/// The same for the error's fault: where `allowed` lists words ("one of a, b", "a|b"), the one nearest to the value, or
/// to the name that is at fault.
std::string did_you_mean(const Error& error);

}  // namespace surfaced
