// SPDX-License-Identifier: GPL-3.0-or-later
// Runs work in a child process and tells what it took: for claims about bad input.
#pragma once

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>

namespace surfaced::testing {

struct ChildRun {
  /// What the work returned, 0..100; -1 if the child died of a signal.
  int result = -1;
  /// Of the processor: what else the machine does meanwhile does not count.
  double seconds = 0;
  /// Memory beyond what the child began with.
  std::uint64_t peak_bytes = 0;
};

/// True where a sanitizer makes time and memory mean nothing.
constexpr bool measuring_is_moot() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return true;
#else
  return false;
#endif
}

inline std::uint64_t peak_memory(const rusage& usage) { return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024; }

inline double processor_seconds(const rusage& usage) {
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Forks, runs `work` (which returns 0..100) and waits for its end.
template <class Work>
ChildRun run_in_child(Work work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work());
  ChildRun run;
  int status = 0;
  rusage usage{};
  if (child < 0 || ::wait4(child, &status, 0, &usage) != child) return run;
  run.seconds = processor_seconds(usage);
  run.peak_bytes = peak_memory(usage);
  if (WIFEXITED(status)) run.result = WEXITSTATUS(status);
  return run;
}

}  // namespace surfaced::testing
