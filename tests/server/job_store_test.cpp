#include <gmock/gmock.h>
#include <sqlite3.h>

#include <algorithm>
#include <thread>

#include "jobs/sqlite_job_store.hpp"
#include "platform/random.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class JobStoreTest : public ::testing::Test {
 protected:
  void SetUp() override { open(); }

  void open() {
    store_.reset();
    auto opened = open_sqlite_job_store(file(), limits_);
    ASSERT_TRUE(opened.ok()) << opened.error().detail;
    store_ = std::move(*opened);
  }
  std::filesystem::path file() const { return directory_.path() / "jobs.sqlite"; }

  Job submit(std::chrono::seconds ttl = std::chrono::hours(1)) {
    const std::string id = random_hex<16>();
    NewJob job{id, "advancing-front", {{"beta", 0.5}}, {id, 7, "abc"}, {"mesh.glb", "report.json", "log.txt"}, "r",
               ttl};
    return store_->submit(job).value();
  }
  ClaimedJob claim() { return store_->claim().value().value(); }
  std::optional<JobStatus> settle(const Claim& claim, Outcome outcome, const std::vector<Output>& outputs = {}) {
    std::optional<Error> error;
    if (outcome != Outcome::done) error = Error{ErrorCode::crashed, "why"};
    return store_->settle(claim, outcome, error, outputs).value();
  }
  Job find(const std::string& id) { return store_->find(id).value(); }

  testing::TemporaryDirectory directory_;
  JobStoreLimits limits_;
  std::unique_ptr<JobStore> store_;
};

TEST_F(JobStoreTest, a_job_survives_closing_and_opening_the_store) {
  const Job made = submit();
  open();
  const Job found = find(made.id);
  EXPECT_EQ(found.method, "advancing-front");
  EXPECT_EQ(found.parameters.dump(), R"({"beta":0.5})");
  EXPECT_EQ(found.input.bytes, 7U);
  EXPECT_EQ(found.created_at, made.created_at);
  EXPECT_EQ(found.status, JobStatus::accepted);
  EXPECT_THAT(found.wanted, ElementsAre("mesh.glb", "report.json", "log.txt"));
}

TEST_F(JobStoreTest, jobs_are_claimed_in_the_order_of_their_submission) {
  const Job first = submit();
  const Job second = submit();
  EXPECT_EQ(find(first.id).queue_position, 0U);
  EXPECT_EQ(find(second.id).queue_position, 1U);
  EXPECT_EQ(claim().job.id, first.id);
  EXPECT_EQ(find(second.id).queue_position, 0U);
  EXPECT_EQ(claim().job.id, second.id);
  EXPECT_FALSE(store_->claim().value().has_value());
}

TEST_F(JobStoreTest, the_queue_has_a_bound) {
  limits_.queue = 2;
  open();
  submit();
  submit();
  EXPECT_EQ(store_->check_room().error().code, ErrorCode::queue_full);
  const auto third = store_->submit({random_hex<16>(), "m", {}, {}, {}, "", std::chrono::seconds(60)});
  ASSERT_FALSE(third.ok());
  EXPECT_EQ(third.error().detail, "2 jobs are waiting, the limit is 2");
  claim();
  EXPECT_TRUE(store_->check_room().ok());
}

TEST_F(JobStoreTest, outputs_and_state_become_visible_together) {
  submit();
  const ClaimedJob claimed = claim();
  store_->report(claimed.claim(), 0.25, "read");
  EXPECT_EQ(find(claimed.job.id).progress, 0.25);
  EXPECT_EQ(find(claimed.job.id).phase, "read");
  EXPECT_EQ(settle(claimed.claim(), Outcome::done, {{"mesh.glb", 1, 12, "feed"}}), JobStatus::successful);
  const Job job = find(claimed.job.id);
  ASSERT_EQ(job.outputs.size(), 1U);
  EXPECT_EQ(job.outputs.front().sha256, "feed");
  EXPECT_EQ(job.progress, 1);
  EXPECT_EQ(*job.expires_at - *job.finished_at, std::chrono::hours(1));
}

TEST_F(JobStoreTest, a_claim_that_was_lost_changes_nothing_any_more) {
  submit();
  const ClaimedJob old = claim();
  EXPECT_EQ(store_->recover().value(), 1U);
  const ClaimedJob now = claim();
  EXPECT_EQ(now.job.id, old.job.id);
  EXPECT_EQ(now.job.attempt, 2U);
  EXPECT_EQ(settle(old.claim(), Outcome::done, {{"mesh.glb", 1, 1, "stale"}}), std::nullopt);
  store_->report(old.claim(), 0.9, "stale");
  EXPECT_EQ(find(now.job.id).status, JobStatus::running);
  EXPECT_EQ(find(now.job.id).progress, 0);
  EXPECT_EQ(settle(now.claim(), Outcome::done, {{"mesh.glb", 2, 1, "fresh"}}), JobStatus::successful);
  EXPECT_EQ(settle(now.claim(), Outcome::crashed), std::nullopt);
  EXPECT_EQ(find(now.job.id).outputs.front().sha256, "fresh");
}

TEST_F(JobStoreTest, the_result_of_a_dismissed_job_is_not_taken) {
  submit();
  const ClaimedJob claimed = claim();
  EXPECT_FALSE(store_->dismiss(claimed.job.id).value().removed);
  EXPECT_EQ(settle(claimed.claim(), Outcome::done, {{"mesh.glb", 1, 1, "x"}}), std::nullopt);
  const Job job = find(claimed.job.id);
  EXPECT_EQ(job.status, JobStatus::dismissed);
  EXPECT_TRUE(job.outputs.empty());
  EXPECT_TRUE(job.expires_at.has_value());
}

TEST_F(JobStoreTest, a_crash_gives_one_more_attempt_and_no_third) {
  const Job job = submit();
  EXPECT_EQ(settle(claim().claim(), Outcome::crashed), JobStatus::accepted);
  EXPECT_FALSE(find(job.id).started_at.has_value());
  EXPECT_EQ(settle(claim().claim(), Outcome::out_of_memory), JobStatus::failed);
  EXPECT_EQ(find(job.id).error->code, ErrorCode::crashed);
}

TEST_F(JobStoreTest, twenty_losses_park_a_job_and_draining_costs_nothing) {
  const Job job = submit();
  for (int i = 0; i < 30; ++i) EXPECT_EQ(settle(claim().claim(), Outcome::drained), JobStatus::accepted);
  for (int i = 1; i < 20; ++i) {
    claim();
    store_->recover().value();
    EXPECT_EQ(find(job.id).status, JobStatus::accepted) << i;
  }
  claim();
  store_->recover().value();
  EXPECT_EQ(find(job.id).status, JobStatus::failed);
  EXPECT_EQ(find(job.id).error->code, ErrorCode::lost);
}

TEST_F(JobStoreTest, a_refused_input_is_not_tried_again) {
  for (const Outcome outcome : {Outcome::input_invalid, Outcome::method_failed, Outcome::timed_out}) {
    submit();
    EXPECT_EQ(settle(claim().claim(), outcome), JobStatus::failed) << name_of(outcome);
  }
}

TEST_F(JobStoreTest, a_removed_job_is_gone_and_then_forgotten) {
  limits_.tombstone = std::chrono::seconds(0);
  open();
  const Job job = submit();
  settle(claim().claim(), Outcome::done, {{"mesh.glb", 1, 1, "x"}, {"report.json", 1, 1, "y"}});
  const Dismissal dismissal = store_->dismiss(job.id).value();
  EXPECT_TRUE(dismissal.removed);
  EXPECT_THAT(dismissal.garbage.inputs, ElementsAre(job.id));
  ASSERT_EQ(dismissal.garbage.outputs.size(), 1U);
  EXPECT_EQ(store_->find(job.id).error().code, ErrorCode::job_gone);
  EXPECT_EQ(store_->dismiss(job.id).error().code, ErrorCode::job_gone);
  EXPECT_TRUE(store_->expire().ok());
  EXPECT_EQ(store_->find(job.id).error().code, ErrorCode::job_not_found);
}

TEST_F(JobStoreTest, only_ended_jobs_expire) {
  const Job waiting = submit(std::chrono::seconds(0));
  const ClaimedJob running = claim();
  EXPECT_TRUE(store_->expire().value().inputs.empty());
  settle(running.claim(), Outcome::done);
  EXPECT_THAT(store_->expire().value().inputs, ElementsAre(waiting.id));
  EXPECT_EQ(store_->find(waiting.id).error().code, ErrorCode::job_gone);
}

TEST_F(JobStoreTest, kept_names_every_artifact_that_a_job_refers_to) {
  const Job done = submit();
  settle(claim().claim(), Outcome::done, {{"mesh.glb", 1, 1, "x"}, {"log.txt", 1, 1, "y"}});
  const Job waiting = submit();
  const Artifacts kept = store_->kept().value();
  EXPECT_THAT(kept.inputs, ElementsAre(done.id, waiting.id));
  ASSERT_EQ(kept.outputs.size(), 1U);
  EXPECT_EQ(kept.outputs.front().job, done.id);
}

TEST_F(JobStoreTest, many_threads_claim_every_job_once) {
  constexpr int kJobs = 60;
  for (int i = 0; i < kJobs; ++i) submit();
  std::mutex mutex;
  std::vector<std::string> claimed;
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (;;) {
        const auto next = store_->claim().value();
        if (!next) return;
        find(next->job.id);
        EXPECT_EQ(settle(next->claim(), Outcome::done), JobStatus::successful);
        const std::scoped_lock lock(mutex);
        claimed.push_back(next->job.id);
      }
    });
  }
  for (auto& thread : threads) thread.join();
  std::ranges::sort(claimed);
  EXPECT_EQ(std::adjacent_find(claimed.begin(), claimed.end()), claimed.end());
  EXPECT_EQ(claimed.size(), static_cast<std::size_t>(kJobs));
}

TEST_F(JobStoreTest, a_store_of_a_newer_version_is_refused) {
  store_.reset();
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file().c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "PRAGMA user_version = 99", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  const auto opened = open_sqlite_job_store(file(), limits_);
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().detail, HasSubstr("has version 99"));
}

TEST_F(JobStoreTest, a_file_that_is_no_database_is_an_error_and_is_left_alone) {
  const auto other = directory_.path() / "other.sqlite";
  FILE* out = std::fopen(other.c_str(), "w");
  std::fputs("this is a text and no database, and longer than a header of one would be .......................", out);
  std::fclose(out);
  EXPECT_FALSE(open_sqlite_job_store(other, limits_).ok());
  EXPECT_GT(std::filesystem::file_size(other), 90U);
}

}  // namespace
}  // namespace surfaced
