// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace surfaced {

// The shadow memory of the sanitizers is data to the kernel, terabytes of it, and the search for leaks traces
// the process from another one.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace surfaced
