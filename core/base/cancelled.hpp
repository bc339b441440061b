// SPDX-License-Identifier: GPL-3.0-or-later
// How a run is stopped inside code of others.
#pragma once

#include "base/context.hpp"

namespace surfaced {

/// Thrown through libraries that have no other way out; caught at the wall of the room that calls them.
struct Cancelled {};

/// Throws Cancelled once the caller wants to stop.
inline void stop_if_cancelled(const Context& context) {
  if (context.cancelled()) throw Cancelled{};
}

}  // namespace surfaced
