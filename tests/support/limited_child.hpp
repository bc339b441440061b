// Runs work in a child process and tells what it took: for claims about bad input.
#pragma once

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>

namespace surfaced::testing {

struct ChildRun {
  /// What the work returned, 0..100; -1 if the child died of a signal.
  int result = -1;
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

/// Forks, runs `work` (which returns 0..100) and waits for its end.
template <class Work>
ChildRun run_in_child(Work work) {
  const auto begin = std::chrono::steady_clock::now();
  rusage before{};
  ::getrusage(RUSAGE_SELF, &before);
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work());
  ChildRun run;
  int status = 0;
  rusage usage{};
  if (child < 0 || ::wait4(child, &status, 0, &usage) != child) return run;
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  run.peak_bytes = peak_memory(usage);
  if (WIFEXITED(status)) run.result = WEXITSTATUS(status);
  return run;
}

}  // namespace surfaced::testing
