// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/attempt_runner.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "support/limited_child.hpp"
#include "support/patience.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

class AttemptRunnerTest : public ::testing::Test {
 protected:
  AttemptSpec spec_for(const std::string& behaviour) const {
    AttemptSpec spec;
    spec.claim = {"job", 1};
    spec.parameters = {{"behave", behaviour}};
    spec.directory = directory_.path() / "a";
    spec.cloud = directory_.path() / "cloud";
    spec.mesh = "mesh.glb";
    spec.limits = limits_;
    spec.parent = ::getpid();
    spec.guarded = guarded_;
    return spec;
  }
  AttemptResult run(const std::string& behaviour) { return run(behaviour, runner_); }
  AttemptResult run(const std::string& behaviour, const AttemptRunner& runner) {
    std::filesystem::remove_all(directory_.path() / "a");
    std::filesystem::create_directory(directory_.path() / "a");
    std::ofstream(directory_.path() / "cloud") << "cloud";
    auto log = AttemptLog::create(directory_.path() / "a/log.txt").value();
    const AttemptSpec spec = spec_for(behaviour);
    const auto began = Clock::now();
    AttemptResult result = runner.run(spec, *stop_, log, [&](double fraction, std::string_view phase) {
      progress_ = fraction;
      phase_ = phase;
      if (!stop_on_progress_) return;
      stopped_ = Clock::now();
      stop_->stop(Outcome::cancelled);
    });
    log.close();
    elapsed_ = testing::seconds_since(began);
    return result;
  }
  /// From the order to stop until the child is gone, at best.
  double seconds_to_cancel(const std::string& behaviour, double limit) {
    stop_on_progress_ = true;
    return testing::best_of_tries(limit, [&] {
      stop_.emplace();
      EXPECT_EQ(run(behaviour).outcome, Outcome::cancelled);
      return testing::seconds_since(stopped_);
    });
  }
  std::string log_text() const {
    std::ostringstream text;
    text << std::ifstream(directory_.path() / "a/log.txt").rdbuf();
    return text.str();
  }

  testing::TemporaryDirectory directory_;
  AttemptLimits limits_{std::uint64_t{256} << 20, 1000, std::uint64_t{1} << 30, std::chrono::seconds(120), 1};
  AttemptRunner runner_{{SURFACED_STAND_IN}};
  std::optional<StopSignal> stop_{std::in_place};
  bool stop_on_progress_ = false;
  bool guarded_ = false;
  double progress_ = 0;
  std::string phase_;
  Clock::time_point stopped_;
  double elapsed_ = 0;
};

TEST_F(AttemptRunnerTest, a_child_that_ends_well_is_done) {
  const AttemptResult result = run("done");
  EXPECT_EQ(result.outcome, Outcome::done) << (result.error ? result.error->detail : "");
  EXPECT_EQ(progress_, 0.5);
  EXPECT_EQ(phase_, "half");
}

TEST_F(AttemptRunnerTest, a_refused_input_keeps_its_own_code) {
  const AttemptResult result = run("refuse");
  EXPECT_EQ(result.outcome, Outcome::input_invalid);
  EXPECT_EQ(result.error->code, ErrorCode::collinear);
}

TEST_F(AttemptRunnerTest, a_crash_names_its_signal) {
  const AttemptResult result = run("crash");
  EXPECT_EQ(result.outcome, Outcome::crashed);
  // A sanitizer takes the signal and exits by itself.
  if (!testing::measuring_is_moot()) {
    EXPECT_THAT(result.error->detail, HasSubstr("SIGSEGV"));
  }
}

TEST_F(AttemptRunnerTest, an_exit_without_a_reason_is_a_crash) {
  const AttemptResult result = run("exit 7");
  EXPECT_EQ(result.outcome, Outcome::crashed);
  EXPECT_THAT(result.error->detail, HasSubstr("exit code 7"));
}

TEST_F(AttemptRunnerTest, a_child_that_allocates_without_end_meets_its_limit) {
  if (testing::measuring_is_moot()) GTEST_SKIP() << "the limit of memory is off under a sanitizer";
  const AttemptResult result = run("allocate");
  EXPECT_EQ(result.outcome, Outcome::out_of_memory);
  EXPECT_EQ(result.error->detail, "as the test asked") << "the kernel refuses before the server looks";
}

TEST_F(AttemptRunnerTest, memory_that_no_limit_of_the_kernel_counts_is_counted_by_the_server) {
  if (testing::measuring_is_moot()) GTEST_SKIP() << "a sanitizer's own memory is counted too";
  const AttemptResult result = run("share");
  EXPECT_EQ(result.outcome, Outcome::out_of_memory);
  EXPECT_THAT(result.error->detail, HasSubstr("limit of 268435456 bytes"));
  EXPECT_GT(result.usage.peak_memory_bytes, limits_.memory_bytes);
}

TEST_F(AttemptRunnerTest, an_output_without_end_meets_its_limit_and_is_not_tried_again) {
  limits_.file_bytes = std::uint64_t{4} << 20;
  const AttemptResult result = run("write");
  EXPECT_EQ(result.outcome, Outcome::method_failed);
  EXPECT_THAT(result.error->detail, HasSubstr("4194304 bytes"));
}

TEST_F(AttemptRunnerTest, what_an_attempt_used_is_measured) {
  const AttemptResult result = run("done");
  EXPECT_GT(result.usage.seconds, 0);
  EXPECT_LE(result.usage.seconds, elapsed_);
  EXPECT_GT(result.usage.peak_memory_bytes, std::uint64_t{1} << 20);
}

TEST_F(AttemptRunnerTest, a_confined_child_can_do_its_work) {
  EXPECT_EQ(run("threads").outcome, Outcome::done) << log_text();
}

TEST_F(AttemptRunnerTest, a_child_can_start_no_process_and_signal_none) {
  if (testing::measuring_is_moot()) GTEST_SKIP() << "there is no filter of system calls under a sanitizer";
  EXPECT_EQ(run("try fork").outcome, Outcome::done);
  EXPECT_EQ(run("try kill the parent").outcome, Outcome::done);
}

TEST_F(AttemptRunnerTest, a_socket_another_program_or_a_look_into_another_process_is_the_end_of_a_child) {
  if (testing::measuring_is_moot()) GTEST_SKIP() << "there is no filter of system calls under a sanitizer";
  for (const char* what : {"try a socket", "try exec", "try ptrace"}) {
    const AttemptResult result = run(what);
    EXPECT_EQ(result.outcome, Outcome::crashed) << what;
    EXPECT_THAT(result.error->detail, HasSubstr("SIGSYS, for a system call that an attempt may not make")) << what;
  }
}

TEST_F(AttemptRunnerTest, a_child_sees_no_file_but_its_own) {
  if (run("done"); log_text().find("no landlock") != std::string::npos) GTEST_SKIP() << "this kernel has no Landlock";
  // By Landlock alone, and where there is a namespace of mounts too.
  const AttemptRunner without({SURFACED_STAND_IN}, ChildProcess::Namespaces::shared);
  for (const AttemptRunner* runner : {&without, static_cast<const AttemptRunner*>(&runner_)}) {
    EXPECT_EQ(run("try read a file", *runner).outcome, Outcome::done) << log_text();
    EXPECT_EQ(run("try write a file", *runner).outcome, Outcome::done) << log_text();
  }
}

TEST_F(AttemptRunnerTest, a_job_that_is_removed_while_it_starts_takes_the_namespaces_from_no_other) {
  run("done");
  constexpr const char* kContained = "namespaces of user";
  if (log_text().find(kContained) == std::string::npos) GTEST_SKIP() << "none on this machine: " << log_text();
  for (auto removed : {&AttemptSpec::cloud, &AttemptSpec::directory}) {
    AttemptSpec spec = spec_for("done");
    spec.*removed = directory_.path() / "removed";
    std::filesystem::remove(directory_.path() / "log.txt");
    auto log = AttemptLog::create(directory_.path() / "log.txt").value();
    EXPECT_NE(runner_.run(spec, *stop_, log, [](double, std::string_view) {}).outcome, Outcome::done);
    EXPECT_EQ(run("done").outcome, Outcome::done);
    EXPECT_THAT(log_text(), HasSubstr(kContained));
  }
}

TEST_F(AttemptRunnerTest, root_works_in_folders_that_only_root_reaches) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root has power over the folders of others";
  constexpr uid_t kNobody = 65534;
  ASSERT_EQ(::chown(directory_.path().c_str(), kNobody, kNobody), 0);
  std::filesystem::permissions(directory_.path(), std::filesystem::perms::owner_all);
  EXPECT_EQ(run("done").outcome, Outcome::done) << log_text();
  EXPECT_THAT(log_text(), HasSubstr("no capability but CAP_DAC_OVERRIDE"));
}

TEST_F(AttemptRunnerTest, a_child_that_hangs_is_stopped_at_its_limit_of_time) {
  limits_.time = std::chrono::seconds(1);
  const AttemptResult result = run("hang");
  EXPECT_EQ(result.outcome, Outcome::timed_out);
  EXPECT_THAT(result.error->detail, HasSubstr("limit of 1 s"));
  EXPECT_GE(elapsed_, 1);
}

TEST_F(AttemptRunnerTest, a_child_that_spins_is_stopped_at_its_limit_of_time) {
  limits_.time = std::chrono::seconds(1);
  EXPECT_EQ(run("spin").outcome, Outcome::timed_out);
}

TEST_F(AttemptRunnerTest, a_child_that_takes_longer_than_clouds_of_its_size_do_ends_long_before_the_operators_limit) {
  const AttemptResult result = run("exceed time");
  EXPECT_EQ(result.outcome, Outcome::timed_out) << log_text();
  EXPECT_THAT(result.error->detail, HasSubstr("3 points with method"));
  EXPECT_LT(elapsed_, static_cast<double>(limits_.time.count()));
}

TEST_F(AttemptRunnerTest, a_child_that_takes_more_memory_than_clouds_of_its_size_do_meets_that_limit) {
  if (testing::measuring_is_moot()) GTEST_SKIP() << "the limit of memory is off under a sanitizer";
  const AttemptResult result = run("exceed memory");
  EXPECT_EQ(result.outcome, Outcome::out_of_memory) << log_text();
  EXPECT_LT(result.usage.peak_memory_bytes, limits_.memory_bytes / 2);
}

TEST_F(AttemptRunnerTest, cancelling_ends_a_child_at_once) {
  constexpr double kGrace = 0.5;  // what a child gets that does not listen
  EXPECT_LT(seconds_to_cancel("hang", kGrace), kGrace);
}

TEST_F(AttemptRunnerTest, cancelling_kills_a_child_that_does_not_listen) {
  EXPECT_LT(seconds_to_cancel("hang deaf", 2), 2);
}

TEST_F(AttemptRunnerTest, a_child_that_ends_whoever_watches_it_ends_its_guard_and_is_counted) {
  guarded_ = true;
  const AttemptResult result = run("kill the watcher");
  EXPECT_EQ(result.outcome, Outcome::crashed);
  EXPECT_THAT(result.error->detail, HasSubstr("SIGKILL"));
}

TEST_F(AttemptRunnerTest, a_guard_tells_what_the_server_would_have_seen) {
  guarded_ = true;
  EXPECT_EQ(run("done").outcome, Outcome::done) << log_text();
  EXPECT_EQ(progress_, 0.5);
  EXPECT_THAT(log_text(), HasSubstr("seccomp"));
  EXPECT_EQ(run("refuse").error->code, ErrorCode::collinear);
  EXPECT_EQ(run("exit 7").outcome, Outcome::crashed);
  limits_.file_bytes = std::uint64_t{4} << 20;
  EXPECT_EQ(run("write").outcome, Outcome::method_failed);
  limits_.time = std::chrono::seconds(1);
  EXPECT_EQ(run("hang").outcome, Outcome::timed_out);
}

TEST_F(AttemptRunnerTest, cancelling_ends_a_guarded_child_too_that_does_not_listen) {
  guarded_ = true;
  EXPECT_LT(seconds_to_cancel("hang deaf", 2), 2);
}

TEST_F(AttemptRunnerTest, what_a_child_left_running_is_killed_with_it) {
  EXPECT_EQ(run("leave a grandchild").outcome, Outcome::done);
  // The grandchild held the pipes open; that must not have made the server wait for its limit of time.
  EXPECT_LT(elapsed_, 60);
}

TEST_F(AttemptRunnerTest, garbage_on_the_pipe_is_dropped_and_the_log_is_capped) {
  EXPECT_EQ(run("shout").outcome, Outcome::done);
  EXPECT_EQ(progress_, 0.5);
  const std::string log = log_text();
  EXPECT_LT(log.size(), (std::size_t{1} << 20) + 200);
  EXPECT_THAT(log.substr(log.size() - 120), HasSubstr("bytes of output were left out; the limit is 1048576"));
}

TEST_F(AttemptRunnerTest, a_command_that_cannot_be_started_loses_the_attempt_and_nothing_else) {
  const AttemptRunner runner({"/nonexistent/surfaced"});
  const AttemptResult result = run("done", runner);
  EXPECT_EQ(result.outcome, Outcome::lost);
  EXPECT_THAT(result.error->detail, HasSubstr("start a child process"));
}

TEST(AttemptProtocolTest, a_description_comes_back_as_it_was) {
  AttemptSpec spec;
  spec.claim = {"j", 4};
  spec.parameters = {{"a", "\xFF"}, {"b", 1.5}};
  spec.mesh = "mesh.ply";
  spec.limits.time = std::chrono::seconds(4);
  spec.parent = 6;
  const AttemptSpec back = decode_attempt(encode(spec)).value();
  EXPECT_EQ(back.claim.attempt, 4U);
  EXPECT_EQ(back.parameters.at("b"), 1.5);
  EXPECT_EQ(back.mesh, "mesh.ply");
  EXPECT_EQ(back.limits.time, std::chrono::seconds(4));
  EXPECT_EQ(back.parent, 6);
}

TEST(AttemptProtocolTest, a_description_that_lacks_a_field_is_wrong_use) {
  EXPECT_EQ(decode_attempt("{}").error().code, ErrorCode::invalid_usage);
  EXPECT_EQ(decode_attempt("nonsense").error().code, ErrorCode::invalid_usage);
}

TEST(AttemptProtocolTest, messages_that_are_none_are_dropped) {
  for (const char* line :
       {"", "1", "null", "[]", "{}", R"({"progress":"x"})", R"({"progress":-1})", R"({"progress":1e999})",
        R"({"code":"nope"})", R"({"code":1})", "{\"progress\":0.5", "\xFF"}) {
    EXPECT_TRUE(std::holds_alternative<std::monostate>(decode_message(line))) << line;
  }
  EXPECT_EQ(std::get<Error>(decode_message(R"({"code":"collinear","detail":"d"})")).detail, "d");
}

}  // namespace
}  // namespace surfaced
