// SPDX-License-Identifier: GPL-3.0-or-later
// What no attempt needs more of, whatever its input.
#pragma once

#include <algorithm>
#include <cstdint>
#include <thread>

#include "worker/attempt_protocol.hpp"

namespace surfaced {

/// Files in an attempt's folder: its outputs, a log, a temporary one each while they are written.
inline constexpr std::uint64_t kMostFiles = 64;
/// Bytes up the two pipes; a log has 1 MiB.
inline constexpr std::uint64_t kMostOutput = std::uint64_t{64} << 20;

/// Threads: pools have one for every processor, or for every thread of the budget, and there are a few of them.
inline std::uint64_t most_threads(const AttemptLimits& limits) {
  return 64 + 4 * std::uint64_t{std::max(limits.threads, std::thread::hardware_concurrency())};
}

/// Bytes that it writes in all, into files that are gone again too: each may be written twice, once before it is whole.
inline std::uint64_t most_written(const AttemptLimits& limits) {
  const std::uint64_t twice = limits.file_bytes > (~std::uint64_t{0} >> 2) ? limits.file_bytes : 2 * limits.file_bytes;
  return twice + kMostOutput;
}

}  // namespace surfaced
