#pragma once

#include <cstdint>
#include <cstring>

#if defined(__x86_64__)
#include <emmintrin.h>
#endif

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

/// Defines NAME(parameters) as a function that runs BODY(arguments) compiled for AVX2 where the machine
/// has it and for the baseline elsewhere. BODY must be SURFACED_INLINE down to its last helper.
#if defined(__x86_64__)
#define SURFACED_TARGET_AVX2 __attribute__((target("avx2")))
inline bool wide_machine() {
  static const bool wide = __builtin_cpu_supports("avx2") != 0;
  return wide;
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

/// Bit i set where lane i of `values` is at most `limit`.
SURFACED_INLINE unsigned at_most(const Floats& values, float limit) {
  const Floats limits{limit, limit, limit, limit};
#if defined(__x86_64__)
  __m128 a;
  __m128 b;
  std::memcpy(&a, &values, sizeof a);
  std::memcpy(&b, &limits, sizeof b);
  return static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(a, b)));
#else
  unsigned bits = 0;
  for (unsigned i = 0; i < 4; ++i) bits |= (values[i] <= limits[i] ? 1U : 0U) << i;
  return bits;
#endif
}

}  // namespace surfaced::lanes
