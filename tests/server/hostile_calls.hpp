// SPDX-License-Identifier: GPL-3.0-or-later
// What a child does that was taken over by its input, with its confinement on.
#pragma once

#include <cstdint>
#include <string>

#include "worker/attempt_protocol.hpp"

namespace surfaced::testing {

/// Asks for everything by which a process reaches another one, a file that is not its own, or more than it was given.
/// @return  what it got, comma-separated; empty if all was refused
std::string reach_out(const AttemptSpec& spec);

/// Whether it can tell if there is a file that is none of its own.
bool sees_other_files();

/// Makes system calls at random from many threads, with arguments that name other processes, other files, other
/// memory, for some tens of milliseconds. Never returns; ends as it happens.
[[noreturn]] void call_anything(const AttemptSpec& spec, std::uint64_t seed);

/// Makes the call of this name, without sense.
void call_by_name(const std::string& name);

}  // namespace surfaced::testing
