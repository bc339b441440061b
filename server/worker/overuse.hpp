// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "base/base.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/child_process.hpp"

namespace surfaced {

/// More than an attempt may use, and how it ends for that.
struct Overuse {
  Outcome outcome = Outcome::crashed;
  Error error;
};

/// Looks at the memory, the threads and the folder of a child: limits that the kernel does not keep (memory that is
/// shared, threads of root, files), or that the child sets upon itself and are only as good as the child.
/// @cost  a few files of /proc, and the folder's entries up to the number that is too many
std::optional<Overuse> overuse_of(ChildProcess& child, const AttemptSpec& spec);

}  // namespace surfaced
