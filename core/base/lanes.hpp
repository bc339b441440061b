// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>

/// Arithmetic on four doubles at once. The compiler lowers it to whatever the function's target has, and
/// every operation is IEEE's on each lane, so all targets give the same bits.
namespace surfaced::lanes {

inline constexpr std::size_t kLanes = 4;

using Doubles = double __attribute__((vector_size(32)));
using Floats = float __attribute__((vector_size(16)));
/// All bits of a lane set or none.
using Mask = std::int64_t __attribute__((vector_size(32)));

/// For helpers of kernels that are compiled for several targets: a call would cross targets.
#define SURFACED_INLINE inline __attribute__((always_inline))

/// Switch for tests, which compare both ways on one machine.
inline std::atomic<bool> wide_allowed{true};

/// A kernel is one SURFACED_INLINE body, down to its last helper, and two functions that run it: one marked
/// SURFACED_TARGET_AVX2 for machines that have it, one for the baseline.
#if defined(__x86_64__)
#define SURFACED_TARGET_AVX2 __attribute__((target("avx2")))
inline bool wide_machine() {
  static const bool wide = __builtin_cpu_supports("avx2") != 0;
  return wide && wide_allowed.load(std::memory_order_relaxed);
}
#else
#define SURFACED_TARGET_AVX2
inline bool wide_machine() { return false; }
#endif

SURFACED_INLINE void load(const double* from, Doubles& to) { std::memcpy(&to, from, sizeof to); }
SURFACED_INLINE void load(const float* from, Floats& to) { std::memcpy(&to, from, sizeof to); }
SURFACED_INLINE void store(const Doubles& from, double* to) { std::memcpy(to, &from, sizeof from); }
SURFACED_INLINE void store(const Floats& from, float* to) { std::memcpy(to, &from, sizeof from); }
SURFACED_INLINE void fill(double value, Doubles& to) { to = Doubles{value, value, value, value}; }

using Counts = std::int32_t __attribute__((vector_size(16)));

/// Adds 1 to every lane of `counts` whose value is at most `limit`.
SURFACED_INLINE void count_at_most(const Floats& values, float limit, Counts& counts) {
  counts -= values <= Floats{limit, limit, limit, limit};
}

}  // namespace surfaced::lanes
