// SPDX-License-Identifier: GPL-3.0-or-later
// A child that was taken over by its input: it cannot reach the server, its siblings, other files, or more than it was
// given. Everything is tried with namespaces, where the kernel gives them, and without.
#include <gmock/gmock.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include "support/limited_child.hpp"
#include "support/patience.hpp"
#include "support/temporary_directory.hpp"
#include "worker/attempt_bounds.hpp"
#include "worker/attempt_runner.hpp"
#include "worker/syscall_rules.hpp"

namespace surfaced {
namespace {

using Namespaces = ChildProcess::Namespaces;
using ::testing::HasSubstr;

class HostileChildTest : public ::testing::TestWithParam<Namespaces> {
 protected:
  void SetUp() override {
    if (testing::measuring_is_moot()) GTEST_SKIP() << "there is no filter of system calls under a sanitizer";
    std::ofstream(directory_.path() / "cloud") << "cloud";
  }

  struct Ending {
    AttemptResult result;
    std::string log;
    std::uint64_t files = 0;
  };

  /// Safe in threads.
  Ending run(const std::string& behaviour, const StopSignal& stop) {
    AttemptSpec spec;
    spec.claim = {"job", 1};
    spec.parameters = {{"behave", behaviour}};
    spec.directory = directory_.path() / std::to_string(++attempts_);
    spec.cloud = directory_.path() / "cloud";
    spec.mesh = "mesh.glb";
    spec.limits = limits_;
    spec.parent = ::getpid();
    std::filesystem::create_directory(spec.directory);
    Ending ending;
    {
      auto log = AttemptLog::create(spec.directory / "log.txt").value();
      ending.result = runner_.run(spec, stop, log, [](double, std::string_view) {});
    }
    std::ostringstream text;
    text << std::ifstream(spec.directory / "log.txt").rdbuf();
    ending.log = text.str();
    ending.files = std::filesystem::remove_all(spec.directory) - 1;
    return ending;
  }
  Ending run(const std::string& behaviour) { return run(behaviour, StopSignal()); }
  static bool contained(const Ending& ending) { return ending.log.find("namespaces of user") != std::string::npos; }

  testing::TemporaryDirectory directory_;
  AttemptLimits limits_{std::uint64_t{256} << 20, 1000, std::uint64_t{16} << 20, std::chrono::seconds(60), 1};
  AttemptRunner runner_{{SURFACED_STAND_IN}, GetParam()};
  std::atomic<int> attempts_ = 0;
};

TEST_P(HostileChildTest, everything_by_which_it_could_reach_others_is_refused) {
  const Ending ending = run("hostile reach out");
  EXPECT_EQ(ending.result.outcome, Outcome::done)
      << "it got: " << (ending.result.error ? ending.result.error->detail : "") << "\n"
      << ending.log;
}

TEST_P(HostileChildTest, what_only_an_intruder_calls_ends_it) {
  for (const SyscallRule& deadly : deadly_calls()) {
    const Ending ending = run(std::string("hostile call ") + deadly.name);
    EXPECT_EQ(ending.result.outcome, Outcome::crashed) << deadly.name;
    EXPECT_THAT(ending.result.error->detail, HasSubstr("SIGSYS")) << deadly.name;
  }
#ifdef __x86_64__
  EXPECT_THAT(run("hostile x32").result.error->detail, HasSubstr("SIGSYS"));
#endif
}

TEST_P(HostileChildTest, with_a_mount_namespace_it_cannot_tell_what_other_files_there_are) {
  const Ending ending = run("hostile look around");
  const bool hidden = ending.log.find("PID and mount") != std::string::npos;
  if (GetParam() == Namespaces::shared) {
    EXPECT_THAT(ending.log, HasSubstr("no namespaces"));
  }
  if (!hidden) GTEST_SKIP() << "no mount namespace: " << ending.log;
  EXPECT_EQ(ending.result.outcome, Outcome::done);
}

TEST_P(HostileChildTest, its_files_are_bounded_in_number) {
  const Ending ending = run("hostile files");
  EXPECT_EQ(ending.result.outcome, Outcome::crashed);
  EXPECT_THAT(ending.result.error->detail, HasSubstr("64 files"));
  // Between two looks of the server some more are made.
  EXPECT_LT(ending.files, 50'000U);
}

TEST_P(HostileChildTest, its_files_are_bounded_in_bytes_together) {
  const Ending ending = run("hostile bytes");
  EXPECT_EQ(ending.result.outcome, Outcome::method_failed);
  EXPECT_THAT(ending.result.error->detail, HasSubstr("the outputs together would be more than the limit of 16777216"));
}

TEST_P(HostileChildTest, it_is_lost_when_it_takes_what_is_to_stay_free_of_the_disk) {
  limits_.minimum_free = ~std::uint64_t{0};
  // Its own bound is not what it meets first.
  limits_.file_bytes = std::uint64_t{1} << 30;
  const Ending ending = run("hostile bytes");
  EXPECT_EQ(ending.result.outcome, Outcome::lost);
  EXPECT_EQ(ending.result.error->code, ErrorCode::storage_full);
}

TEST_P(HostileChildTest, files_that_it_removes_while_they_are_open_are_counted_too) {
  const Ending ending = run("hostile hidden files");
  if (!std::filesystem::exists("/proc/self/io")) GTEST_SKIP() << "this kernel does not count what a process writes";
  EXPECT_EQ(ending.result.outcome, Outcome::method_failed) << ending.result.error->detail;
  EXPECT_THAT(ending.result.error->detail, HasSubstr("the work wrote more than the limit"));
}

TEST_P(HostileChildTest, its_threads_are_bounded) {
  // Their stacks are not what it meets first.
  limits_.memory_bytes = std::uint64_t{8} << 30;
  const Ending ending = run("hostile threads");
  const std::string& detail = ending.result.error->detail;
  // By the kernel where a user namespace of a user counts, else by the server's look.
  if (contained(ending) && ::geteuid() != 0) {
    EXPECT_EQ(ending.result.outcome, Outcome::method_failed);
    EXPECT_LE(std::stoull(detail), most_threads(limits_));
  } else {
    EXPECT_EQ(ending.result.outcome, Outcome::crashed);
    EXPECT_THAT(detail, HasSubstr("threads"));
  }
}

TEST_P(HostileChildTest, its_limits_are_set_before_its_work_begins) {
  const Ending ending = run("hostile limits");
  std::map<std::string, std::uint64_t> limits;
  std::istringstream words(ending.result.error->detail);
  for (std::string name; words >> name;) words >> limits[name];
  const std::map<std::string, std::uint64_t> expected{{"DATA", limits_.memory_bytes},
                                                      {"FSIZE", limits_.file_bytes},
                                                      {"NOFILE", 64},
                                                      {"CORE", 0},
                                                      {"CPU", limits_.time.count()}};
  for (const auto& [name, limit] : expected) EXPECT_EQ(limits[name], limit) << name;
  if (contained(ending)) {
    EXPECT_EQ(limits["NPROC"], most_threads(limits_) + 1) << "of the only user of its namespace";
  }
}

TEST_P(HostileChildTest, it_cannot_keep_the_server_busy_with_words) {
  const Ending ending = run("hostile words");
  EXPECT_EQ(ending.result.outcome, Outcome::crashed);
  EXPECT_THAT(ending.result.error->detail, HasSubstr("67108864 bytes"));
}

std::atomic<int> signals_received = 0;

/// Counts signals that a process gets from descriptors and from strangers.
class SignalCount {
 public:
  SignalCount() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) {
      before_[i] = std::signal(kSignals[i], [](int) { ++signals_received; });
    }
  }
  ~SignalCount() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) std::signal(kSignals[i], before_[i]);
  }
  SignalCount(const SignalCount&) = delete;
  SignalCount& operator=(const SignalCount&) = delete;

 private:
  static constexpr std::array kSignals{SIGIO, SIGURG, SIGUSR1, SIGUSR2, SIGHUP, SIGALRM, SIGVTALRM};
  std::array<void (*)(int), kSignals.size()> before_{};
};

TEST_P(HostileChildTest, whatever_it_calls_at_random_the_server_and_its_siblings_live_fifty_of_fifty_times) {
  const SignalCount count;
  StopSignal stop_sibling;
  Ending sibling;
  std::thread waiting([&] { sibling = run("hang", stop_sibling); });
  std::thread working([&] {
    for (int i = 0; i < 10; ++i) EXPECT_EQ(run("threads").result.outcome, Outcome::done);
  });
  std::vector<std::thread> attackers;
  std::atomic<int> round = 0;
  int seen = 0;
  for (int i = 0; i < 4; ++i) {
    attackers.emplace_back([&] {
      for (int seed = ++round; seed <= 50; seed = ++round) {
        const Ending ending = run("hostile seed " + std::to_string(seed));
        EXPECT_NE(ending.result.outcome, Outcome::lost) << seed;
        EXPECT_NE(ending.result.outcome, Outcome::timed_out) << seed;
      }
    });
  }
  for (std::thread& each : attackers) each.join();
  working.join();
  stop_sibling.stop(Outcome::cancelled);
  waiting.join();
  seen = signals_received;
  EXPECT_EQ(sibling.result.outcome, Outcome::cancelled) << "a sibling did not live to be cancelled";
  EXPECT_EQ(seen, 0) << "signals reached the server";
}

INSTANTIATE_TEST_SUITE_P(Namespaces, HostileChildTest, ::testing::Values(Namespaces::its_own, Namespaces::shared),
                         [](const auto& each) {
                           return std::string(each.param == Namespaces::its_own ? "with" : "without") + "_namespaces";
                         });

}  // namespace
}  // namespace surfaced
