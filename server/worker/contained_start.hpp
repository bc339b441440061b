// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

namespace surfaced {

/// What the first process of a PID namespace ends with if it cannot do without what its namespaces keep from it. The
/// work has not begun then.
inline constexpr int kCannotBeContained = 125;

/// What it ends with if the paths of its work are not there for it: its user has no right to them, or they are gone.
inline constexpr int kPathsNotReached = 124;

/// What it adds to the number of the signal that has ended the work.
inline constexpr int kEndedBySignal = 128;

/// Starts a program in user, PID and mount namespaces of its own, as the leader of a process group, with no input and
/// no descriptors but the two pipes: `output` as 1 and 2, `messages` as kMessageDescriptor. It is process 1 there: when
/// it ends, the kernel ends every other process of the namespace and returns it to its parent only after that.
/// Safe in a process of many threads.
/// @return  its id, or -1 if the kernel, or who restricts this process, does not let it. If the program cannot be
///          started, the process ends with kCannotBeContained.
pid_t start_contained(char* const* command, char* const* environment, int output, int messages);

}  // namespace surfaced
