// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: which methods there are. Alone, so that a program can bring a table of its own.
#pragma once

#include <vector>

#include "reconstruction/methods.hpp"

namespace surfaced {

/// All of them, the default one first.
std::vector<Method> all_methods();

}  // namespace surfaced
