// SPDX-License-Identifier: GPL-3.0-or-later
#include "execution/scheduler.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <new>
#include <optional>
#include <thread>

#include "artifacts/file_artifact_store.hpp"
#include "jobs/sqlite_job_store.hpp"
#include "platform/files.hpp"
#include "platform/random.hpp"
#include "support/patience.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::HasSubstr;

class SchedulerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    jobs_ = open_sqlite_job_store(directory_.path() / "jobs.sqlite", {}).value();
    artifacts_ = open_file_artifact_store(directory_.path(), 0).value();
    start();
  }
  void start(unsigned workers = 2, std::function<void(const Scheduler::Ended&)> ended = {}) {
    const AttemptLimits limits{std::uint64_t{256} << 20, 1000, std::uint64_t{1} << 30, std::chrono::seconds(300), 1};
    scheduler_.emplace(*jobs_, *artifacts_, events_, runner_,
                       Scheduler::Options{workers, limits, std::chrono::seconds(10), std::move(ended)});
    scheduler_->start();
  }
  std::string submit(const std::string& behaviour) {
    std::string id = random_hex<16>();
    auto upload = artifacts_->begin_upload().value();
    EXPECT_TRUE(upload->write(as_bytes("cloud")).ok());
    const NewJob job{
        id,  "m", {{"behave", behaviour}}, upload->commit(id).value(), {"mesh.glb", "report.json", "log.txt"},
        "r", "",  std::chrono::hours(1)};
    EXPECT_TRUE(jobs_->submit(job).ok());
    if (scheduler_) scheduler_->wake();
    return id;
  }
  /// The job once it satisfies the condition.
  Job wait_for(const std::string& id, const std::function<bool(const Job&)>& condition) {
    EXPECT_TRUE(testing::eventually([&] { return condition(jobs_->find(id).value()); }, std::chrono::seconds(120)));
    return jobs_->find(id).value();
  }
  Job wait_for_end(const std::string& id) {
    return wait_for(id, [](const Job& job) { return ended(job.status); });
  }
  std::size_t attempts_on_disk() const {
    const std::filesystem::directory_iterator entries(directory_.path() / "attempts");
    return static_cast<std::size_t>(std::distance(begin(entries), end(entries)));
  }

  testing::TemporaryDirectory directory_;
  std::unique_ptr<JobStore> jobs_;
  std::unique_ptr<ArtifactStore> artifacts_;
  JobEvents events_;
  AttemptRunner runner_{{SURFACED_STAND_IN}};
  std::optional<Scheduler> scheduler_;
};

TEST_F(SchedulerTest, a_job_ends_with_its_three_outputs) {
  const Job job = wait_for_end(submit("done"));
  EXPECT_EQ(job.status, JobStatus::successful);
  EXPECT_EQ(job.outputs.size(), 3U);
  EXPECT_EQ(attempts_on_disk(), 0U);
}

TEST_F(SchedulerTest, what_is_thrown_at_the_end_of_an_attempt_costs_its_job_another_attempt_and_no_thread) {
  scheduler_.reset();
  std::atomic<int> ends = 0;
  const std::string first = submit("done");
  const std::string second = submit("done");
  start(1, [&](const Scheduler::Ended&) {
    if (++ends <= 2) throw std::bad_alloc();
  });
  EXPECT_TRUE(testing::eventually([&] { return ends == 2; })) << "one worker had both";
  EXPECT_EQ(jobs_->find(first).value().status, JobStatus::running) << "until its lease is over";
  EXPECT_EQ(jobs_->recover().value(), 2U);
  scheduler_->wake();
  EXPECT_EQ(wait_for_end(first).status, JobStatus::successful);
  EXPECT_EQ(wait_for_end(second).status, JobStatus::successful);
}

TEST_F(SchedulerTest, a_job_that_crashes_once_succeeds_at_the_second_attempt) {
  const Job job = wait_for_end(submit("crash once"));
  EXPECT_EQ(job.status, JobStatus::successful);
  EXPECT_EQ(job.attempt, 2U);
}

TEST_F(SchedulerTest, a_job_that_always_crashes_fails_after_two_attempts_and_keeps_its_log) {
  const Job job = wait_for_end(submit("crash"));
  EXPECT_EQ(job.status, JobStatus::failed);
  EXPECT_EQ(job.attempt, 2U);
  EXPECT_EQ(job.error->code, ErrorCode::crashed);
  ASSERT_EQ(job.outputs.size(), 1U);
  EXPECT_EQ(job.outputs.front().name, "log.txt");
  std::array<std::byte, 4096> bytes{};
  const auto log = artifacts_->open_output({job.id, job.attempt}, "log.txt").value();
  const std::size_t size = log->read(0, bytes).value();
  EXPECT_THAT(std::string(reinterpret_cast<const char*>(bytes.data()), size), HasSubstr("outcome crashed"));
}

TEST_F(SchedulerTest, a_job_under_which_a_server_has_died_is_parked_by_its_second_attempt_to_end_another) {
  scheduler_.reset();
  const std::string id = submit("kill the watcher");
  // The server before died under its first attempt.
  ASSERT_TRUE(jobs_->claim().value().has_value());
  ASSERT_EQ(jobs_->recover().value(), 1U);
  start();
  const Job job = wait_for_end(id);
  EXPECT_EQ(job.status, JobStatus::failed);
  EXPECT_TRUE(job.parked);
  EXPECT_EQ(job.error->code, ErrorCode::crashed);
  EXPECT_EQ(job.attempt, 3U);
}

TEST_F(SchedulerTest, outputs_that_are_missing_or_links_never_become_results) {
  EXPECT_EQ(wait_for_end(submit("nothing")).error->code, ErrorCode::crashed);
  EXPECT_EQ(wait_for_end(submit("litter")).error->code, ErrorCode::crashed);
}

TEST_F(SchedulerTest, a_dismissed_job_stops_within_two_seconds_and_leaves_nothing) {
  const double seconds = testing::best_of_tries(2, [&] {
    const std::string id = submit("hang deaf");
    wait_for(id, [](const Job& job) { return job.phase == "hanging"; });
    const auto began = std::chrono::steady_clock::now();
    EXPECT_FALSE(jobs_->dismiss(id).value().removed);
    scheduler_->cancel(id);
    EXPECT_TRUE(testing::eventually([&] { return attempts_on_disk() == 0; }));
    EXPECT_EQ(jobs_->find(id).value().status, JobStatus::dismissed);
    return testing::seconds_since(began);
  });
  EXPECT_LT(seconds, 2);
}

TEST_F(SchedulerTest, draining_gives_running_jobs_back_without_counting_it) {
  const std::string id = submit("hang");
  wait_for(id, [](const Job& job) { return job.phase == "hanging"; });
  scheduler_->drain(std::chrono::milliseconds(50));
  const Job job = jobs_->find(id).value();
  EXPECT_EQ(job.status, JobStatus::accepted);
  EXPECT_FALSE(job.error.has_value());
  EXPECT_EQ(attempts_on_disk(), 0U);
}

TEST_F(SchedulerTest, many_jobs_of_all_kinds_end_each_as_it_should) {
  std::vector<std::pair<std::string, JobStatus>> submitted;
  for (int i = 0; i < 10; ++i) {
    submitted.emplace_back(submit("done"), JobStatus::successful);
    submitted.emplace_back(submit("refuse"), JobStatus::failed);
    submitted.emplace_back(submit("crash once"), JobStatus::successful);
  }
  for (const auto& [id, status] : submitted) EXPECT_EQ(wait_for_end(id).status, status);
}

}  // namespace
}  // namespace surfaced
