#pragma once

#include "base/base.hpp"
#include "worker/attempt_protocol.hpp"

namespace surfaced {

/// Takes from this process, for good, what an attempt does not need: it dies with its parent, gains no
/// privileges, leaves no core file, and is held to its limits of memory (RLIMIT_DATA, which gives a
/// clean bad_alloc; address space is no measure of memory), processor time, file size and open files.
/// To be called by the child before it touches its input.
Status confine_this_process(const AttemptLimits& limits, int parent);

}  // namespace surfaced
