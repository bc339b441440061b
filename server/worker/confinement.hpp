// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "base/base.hpp"
#include "worker/attempt_protocol.hpp"

namespace surfaced {

/// Takes from this process, for good, what an attempt does not need:
///
///   dies with its parent, has no capabilities and gains none, leaves no core file
///   namespaces of users, processes and mounts, where it was started in them: no process but its own can be named,
///     and no file but its own; the work then goes on in a child of this process, which is all that returns
///   limits of memory (RLIMIT_DATA, which gives a clean bad_alloc; address space is no measure of memory),
///     processor time, size of a file and open files
///   files: reads the cloud, works in the attempt's directory, and nothing else; no signals to others by any way
///     (Landlock, where the kernel has it)
///   system calls: those of reading, writing, memory and threads, with the arguments that are needed; a socket, another
///     program or a look into another process ends it with SIGSYS, anything else that is not on the list fails with
///     EPERM (seccomp)
///
/// To be called by the child before it touches its input and before it starts a thread.
/// @return  which of them are in force, for the log
Result<std::string> confine_this_process(const AttemptSpec& spec);

}  // namespace surfaced
