// SPDX-License-Identifier: GPL-3.0-or-later
// The long run: many cases in children of which each runs thousands, so that one that crashes or takes longer than it
// may costs no other. What was found is named by its number, of which the case can be made again.
//   build/release/geometry_runs COUNT [FIRST [POINTS]]   cases FIRST .. FIRST + COUNT - 1
//   build/release/geometry_runs --keep NUMBER FOLDER     writes that cloud and says how to run it
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <iostream>
#include <map>
#include <string_view>

#include "geometry/geometry_case.hpp"
#include "support/limited_child.hpp"
#include "support/temporary_directory.hpp"

namespace {

using namespace surfaced;
using namespace surfaced::testing;

constexpr rlim_t kMemory = rlim_t{2} << 30;

/// What a child tells the process that started it, in memory that both see.
struct Shared {
  std::uint64_t number;
  std::uint64_t counts[64];
  /// The greatest share of its bound that a case took.
  double worst_share;
  std::uint64_t worst_number;
};

double seconds_so_far() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return processor_seconds(usage);
}

/// Has SIGPROF end the process after so much processor time.
void arm(double seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(seconds);
  timer.it_value.tv_usec = static_cast<suseconds_t>(1e6 * (seconds - static_cast<double>(timer.it_value.tv_sec)));
  ::setitimer(ITIMER_PROF, &timer, nullptr);
}

void count(Shared& shared, std::string_view outcome) {
  ErrorCode code{};
  const bool failed = outcome != "done" && error_code_named(outcome, code);
  ++shared.counts[failed ? static_cast<std::size_t>(code) + 1 : 0];
}

[[noreturn]] void run_in_child(Shared& shared, std::uint64_t end, std::size_t points,
                               const std::filesystem::path& folder) {
  const rlimit memory{kMemory, kMemory};
  ::setrlimit(RLIMIT_DATA, &memory);
  for (; shared.number < end; ++shared.number) {
    const GeometryCase geometry = geometry_case(shared.number, points);
    const double bound = most_cost(*geometry.method, geometry.cloud.size()).seconds;
    const double before = seconds_so_far();
    arm(bound);
    count(shared, run_case(geometry, folder));
    arm(0);
    const double share = (seconds_so_far() - before) / bound;
    if (share <= shared.worst_share) continue;
    shared.worst_share = share;
    shared.worst_number = shared.number;
  }
  std::_Exit(0);
}

void say(const Shared& shared, std::uint64_t run, const std::map<std::uint64_t, int>& found) {
  std::cout << run << " runs, " << found.size() << " ended by a signal\n  done " << shared.counts[0] << "\n";
  for (std::size_t i = 1; i < std::size(shared.counts); ++i) {
    if (shared.counts[i] > 0)
      std::cout << "  " << name_of(static_cast<ErrorCode>(i - 1)) << " " << shared.counts[i] << "\n";
  }
  std::cout << "  most of its bound took case " << shared.worst_number << ": " << 100 * shared.worst_share << " %\n";
}

int run_all(std::uint64_t first, std::uint64_t total, std::size_t points) {
  void* const memory = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return 1;
  auto& shared = *new (memory) Shared{};
  shared.number = first;
  // One for all children: what those leave that end by a signal goes with it.
  const TemporaryDirectory folder;
  std::map<std::uint64_t, int> found;
  const std::uint64_t end = first + total;
  while (shared.number < end) {
    const pid_t child = ::fork();
    if (child < 0) return 1;
    if (child == 0) run_in_child(shared, end, points, folder.path());
    int status = 0;
    if (::waitpid(child, &status, 0) != child) return 1;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) break;
    const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    found[shared.number] = signal;
    std::cout << shared.number << " " << (signal == SIGPROF ? "above its bound" : ::strsignal(signal)) << ": "
              << geometry_case(shared.number, points).text() << std::endl;
    ++shared.number;
  }
  say(shared, total, found);
  return found.empty() ? 0 : 1;
}

int keep(std::uint64_t number, const std::filesystem::path& folder, std::size_t points) {
  const GeometryCase geometry = geometry_case(number, points);
  const std::filesystem::path file = folder / (std::to_string(number) + ".ply");
  const Status written =
      write_file(file, encode_cloud_ply(geometry.cloud.positions, geometry.cloud.normals, geometry.cloud.colors));
  std::cout << "surfaced reconstruct " << file.string() << " -o mesh" << geometry.extension << " --method "
            << geometry.method->id;
  for (const auto& [name, value] : geometry.parameters.items()) {
    if (value == geometry.method->parameters.at("properties").at(name).at("default")) continue;
    std::cout << " --param " << name << "=" << (value.is_string() ? value.get<std::string>() : value.dump());
  }
  std::cout << "\n";
  return written.ok() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr std::size_t kPoints = 300;
  const std::vector<std::string> words(argv + 1, argv + argc);
  const auto number = [&](std::size_t i, std::uint64_t otherwise) {
    return i < words.size() ? std::stoull(words[i]) : otherwise;
  };
  if (words.size() >= 3 && words[0] == "--keep") return keep(number(1, 0), words[2], number(3, kPoints));
  if (words.empty()) return 2;
  return run_all(number(1, 0), number(0, 0), number(2, kPoints));
}
