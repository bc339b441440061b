// SPDX-License-Identifier: GPL-3.0-or-later
// Waiting and measuring, so that a machine which is slow, or busy with another test, fails none.
#pragma once

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>
#include <thread>

namespace surfaced::testing {

/// Waits until the condition holds; false if it never does, which alone takes all the time.
template <class Condition>
bool eventually(const Condition& condition, std::chrono::milliseconds patience = std::chrono::seconds(60)) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

inline double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// What `measure` gives, or the least of a few tries until one is below the limit: what else the machine does makes a
/// try longer, and never shorter.
template <class Measure>
double best_of_tries(double limit, const Measure& measure, int tries = 4) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < tries && best >= limit; ++i) best = std::min(best, measure());
  return best;
}

/// Far more than an answer takes anywhere, and far less than the waits that it must not depend on.
constexpr double kPromptly = 20;
constexpr std::chrono::milliseconds kForLong = std::chrono::seconds(120);

/// Processor time of this process, in seconds, which does not pass while another one runs.
inline double processor_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace surfaced::testing
