// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace surfaced {

/// Bytes of the machine's memory.
std::uint64_t machine_memory();

/// Resident bytes of this process.
std::uint64_t resident_memory();

/// Lets this process open as many files as it may.
/// @return  that number
std::uint64_t raise_file_limit();

}  // namespace surfaced
