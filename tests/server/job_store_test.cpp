// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <sqlite3.h>

#include <algorithm>
#include <thread>

#include "jobs/sqlite_job_store.hpp"
#include "platform/random.hpp"
#include "support/change_store.hpp"
#include "support/patience.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

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
    NewJob job{id, "advancing-front", {{"beta", 0.5}}, {id, 7, "abc"}, {"mesh.glb", "report.json", "log.txt"}, "r", "",
               ttl};
    return store_->submit(job).value();
  }
  ClaimedJob claim() { return store_->claim().value().value(); }
  std::optional<JobStatus> settle(const Claim& claim, Outcome outcome, const std::vector<Output>& outputs = {}) {
    std::optional<Error> error;
    if (outcome != Outcome::done) error = Error{ErrorCode::crashed, "why"};
    return store_->settle(claim, {outcome, error, outputs, {1.5, 1.25, 4096}}).value();
  }
  Job find(const std::string& id) { return store_->find(id).value(); }

  static void change(const char* sql, const std::filesystem::path& where) { testing::change_store(where, sql); }
  void change(const char* sql) { change(sql, file()); }

  /// The tables as the first version made them, with a job of every kind.
  void make_first_version(const std::filesystem::path& where) {
    change(R"sql(
      CREATE TABLE jobs (seq INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, method TEXT NOT NULL,
        parameters TEXT NOT NULL,
        status TEXT NOT NULL CHECK (status IN ('accepted', 'running', 'successful', 'failed', 'dismissed')),
        attempt INTEGER NOT NULL DEFAULT 0, failures INTEGER NOT NULL DEFAULT 0, losses INTEGER NOT NULL DEFAULT 0,
        input_key TEXT NOT NULL, input_bytes INTEGER NOT NULL, input_sha256 TEXT NOT NULL, wanted TEXT NOT NULL,
        request_id TEXT NOT NULL, ttl_seconds INTEGER NOT NULL, created_at TEXT NOT NULL, started_at TEXT,
        finished_at TEXT, expires_at TEXT, removed_at TEXT, error_code TEXT, error_detail TEXT) STRICT;
      CREATE INDEX jobs_active ON jobs (status, seq) WHERE status IN ('accepted', 'running');
      CREATE INDEX jobs_expiry ON jobs (expires_at) WHERE expires_at IS NOT NULL;
      CREATE TABLE outputs (job TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE, name TEXT NOT NULL,
        attempt INTEGER NOT NULL, bytes INTEGER NOT NULL, sha256 TEXT NOT NULL, PRIMARY KEY (job, name))
        STRICT, WITHOUT ROWID;
      INSERT INTO jobs (id, method, parameters, status, attempt, input_key, input_bytes, input_sha256, wanted,
        request_id, ttl_seconds, created_at, started_at, finished_at, expires_at, error_code, error_detail) VALUES
        ('done', 'm', '{}', 'successful', 2, 'k', 1, 's', '["mesh.glb"]', 'r', 60, '2026-01-01T00:00:00.000Z',
         '2026-01-01T00:00:01.000Z', '2026-01-01T00:00:02.000Z', '2999-01-01T00:00:00.000Z', NULL, NULL),
        ('bad', 'm', '{}', 'failed', 1, 'k', 1, 's', '["mesh.glb"]', 'r', 60, '2026-01-01T00:00:00.000Z',
         '2026-01-01T00:00:01.000Z', '2026-01-01T00:00:02.000Z', '2999-01-01T00:00:00.000Z', 'collinear', 'why'),
        ('running', 'm', '{}', 'running', 1, 'k', 1, 's', '["mesh.glb"]', 'r', 60, '2026-01-01T00:00:00.000Z',
         '2026-01-01T00:00:01.000Z', NULL, NULL, NULL, NULL),
        ('waiting', 'm', '{}', 'accepted', 0, 'k', 1, 's', '["mesh.glb"]', 'r', 60, '2026-01-01T00:00:00.000Z',
         NULL, NULL, NULL, NULL, NULL);
      INSERT INTO outputs VALUES ('done', 'mesh.glb', 2, 1, 'x');
      PRAGMA user_version = 1;
    )sql",
           where);
  }

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
  const auto third = store_->submit({random_hex<16>(), "m", {}, {}, {}, "", "", std::chrono::seconds(60)});
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

TEST_F(JobStoreTest, a_job_lists_its_attempts_with_outcome_and_what_they_used) {
  const Job job = submit();
  settle(claim().claim(), Outcome::crashed);
  EXPECT_EQ(claim().job.attempts.size(), 2U);
  Job found = find(job.id);
  ASSERT_EQ(found.attempts.size(), 2U);
  EXPECT_EQ(found.attempts.front().outcome, "crashed");
  EXPECT_EQ(found.attempts.front().error->detail, "why");
  EXPECT_EQ(found.attempts.front().usage.seconds, 1.5);
  EXPECT_EQ(found.attempts.front().usage.peak_memory_bytes, 4096U);
  EXPECT_FALSE(found.attempts.back().ended_at.has_value());
  EXPECT_EQ(found.attempts.back().outcome, "");
  store_->dismiss(job.id).value();
  found = find(job.id);
  EXPECT_EQ(found.attempts.back().outcome, "cancelled");
  EXPECT_TRUE(found.attempts.back().ended_at.has_value());
}

TEST_F(JobStoreTest, only_a_job_whose_attempts_are_used_up_is_parked) {
  const Job poison = submit();
  settle(claim().claim(), Outcome::out_of_memory);
  settle(claim().claim(), Outcome::crashed);
  EXPECT_TRUE(find(poison.id).parked);
  const Job refused = submit();
  settle(claim().claim(), Outcome::input_invalid);
  EXPECT_FALSE(find(refused.id).parked);
}

TEST_F(JobStoreTest, a_parked_job_starts_anew_when_its_client_says_so) {
  const Job job = submit();
  settle(claim().claim(), Outcome::crashed);
  settle(claim().claim(), Outcome::crashed, {{"log.txt", 2, 1, "x"}});
  const Job later = submit();
  const Retry retry = store_->retry(job.id).value();
  EXPECT_EQ(retry.job.status, JobStatus::accepted);
  EXPECT_FALSE(retry.job.parked);
  EXPECT_FALSE(retry.job.error.has_value());
  EXPECT_FALSE(retry.job.expires_at.has_value());
  EXPECT_EQ(retry.job.queue_position, 1U) << "it waits behind what came meanwhile";
  ASSERT_EQ(retry.garbage.outputs.size(), 1U);
  EXPECT_EQ(retry.garbage.outputs.front().attempt, 2U);
  EXPECT_EQ(claim().job.id, later.id);
  EXPECT_EQ(settle(claim().claim(), Outcome::crashed), JobStatus::accepted) << "its failures are forgotten";
  EXPECT_EQ(find(job.id).attempts.size(), 3U);
}

TEST_F(JobStoreTest, a_job_that_is_active_or_successful_cannot_be_tried_again) {
  const Job job = submit();
  EXPECT_EQ(store_->retry(job.id).error().code, ErrorCode::not_retryable);
  const ClaimedJob claimed = claim();
  EXPECT_EQ(store_->retry(job.id).error().code, ErrorCode::not_retryable);
  settle(claimed.claim(), Outcome::done);
  EXPECT_THAT(store_->retry(job.id).error().detail, HasSubstr("is successful"));
  store_->dismiss(job.id).value();
  EXPECT_EQ(store_->retry(job.id).error().code, ErrorCode::job_gone);
  EXPECT_EQ(store_->retry("nothing").error().code, ErrorCode::job_not_found);
}

TEST_F(JobStoreTest, a_retry_finds_the_queue_full_like_a_submission) {
  limits_.queue = 1;
  open();
  const Job job = submit();
  settle(claim().claim(), Outcome::input_invalid);
  submit();
  EXPECT_EQ(store_->retry(job.id).error().code, ErrorCode::queue_full);
  EXPECT_EQ(find(job.id).status, JobStatus::failed);
}

TEST_F(JobStoreTest, a_claim_that_nobody_renews_is_lost_and_one_that_is_renewed_is_not) {
  // Longer than the longest time between two lines below.
  limits_.lease = std::chrono::milliseconds(2500);
  open();
  submit();
  submit();
  const Claim silent = claim().claim();
  const Claim renewed = claim().claim();
  const auto began = std::chrono::steady_clock::now();
  std::vector<Claim> expired;
  EXPECT_TRUE(testing::eventually([&] {
    EXPECT_TRUE(store_->renew(renewed).value());
    expired = store_->expire_leases().value();
    return !expired.empty();
  }));
  EXPECT_GE(std::chrono::steady_clock::now() - began, limits_.lease);
  ASSERT_EQ(expired.size(), 1U);
  EXPECT_EQ(expired.front().job, silent.job);
  EXPECT_EQ(find(silent.job).status, JobStatus::accepted);
  EXPECT_EQ(find(silent.job).attempts.front().outcome, "lost");
  EXPECT_EQ(find(renewed.job).status, JobStatus::running);
  EXPECT_FALSE(store_->renew(silent).value());
  EXPECT_EQ(settle(silent, Outcome::done), std::nullopt);
}

TEST_F(JobStoreTest, a_clock_that_jumps_ends_no_lease) {
  limits_.lease = std::chrono::seconds(20);
  open();
  submit();
  claim();
  store_->expire_leases().value();
  // What a clock set back or forward by years leaves in the file.
  change("UPDATE jobs SET started_at = '1999-01-01T00:00:00.000Z'");
  EXPECT_TRUE(store_->expire_leases().value().empty());
  change("UPDATE jobs SET started_at = '2999-01-01T00:00:00.000Z'");
  EXPECT_TRUE(store_->expire_leases().value().empty());
}

TEST_F(JobStoreTest, a_store_that_another_process_holds_is_not_ready_and_says_so_in_time) {
  limits_.patience = std::chrono::milliseconds(100);
  open();
  const Job job = submit();
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(file().c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  const auto began = std::chrono::steady_clock::now();
  EXPECT_EQ(store_->writable().error().code, ErrorCode::not_ready);
  EXPECT_EQ(store_->claim().error().code, ErrorCode::not_ready);
  EXPECT_LT(testing::seconds_since(began), 30);
  EXPECT_EQ(find(job.id).status, JobStatus::accepted) << "reading goes on";
  sqlite3_exec(other, "ROLLBACK", nullptr, nullptr, nullptr);
  sqlite3_close(other);
  EXPECT_TRUE(store_->writable().ok());
}

TEST_F(JobStoreTest, the_census_counts_what_waits_and_what_runs) {
  const Job first = submit();
  submit();
  Census census = store_->census().value();
  EXPECT_EQ(census.accepted, 2U);
  EXPECT_EQ(census.oldest_accepted, first.created_at);
  claim();
  census = store_->census().value();
  EXPECT_EQ(census.accepted, 1U);
  EXPECT_EQ(census.running, 1U);
}

TEST_F(JobStoreTest, a_store_keeps_its_identity) {
  const std::string identity = store_->identity().value();
  EXPECT_EQ(identity.size(), 32U);
  open();
  EXPECT_EQ(store_->identity().value(), identity);
}

TEST_F(JobStoreTest, a_file_of_the_first_version_is_brought_up_with_all_its_jobs) {
  const auto old = directory_.path() / "old.sqlite";
  make_first_version(old);
  store_.reset();
  auto opened = open_sqlite_job_store(old, limits_);
  ASSERT_TRUE(opened.ok()) << opened.error().detail;
  store_ = std::move(*opened);
  const Job done = find("done");
  EXPECT_EQ(done.status, JobStatus::successful);
  ASSERT_EQ(done.attempts.size(), 1U);
  EXPECT_EQ(done.attempts.front().number, 2U);
  EXPECT_EQ(done.attempts.front().outcome, "done");
  EXPECT_EQ(done.outputs.size(), 1U);
  EXPECT_EQ(find("bad").attempts.front().outcome, "input_invalid");
  EXPECT_EQ(find("waiting").status, JobStatus::accepted);
  EXPECT_TRUE(find("waiting").attempts.empty());
  JobFilter failed;
  failed.statuses = {JobStatus::failed};
  EXPECT_EQ(store_->list(failed, 10, std::nullopt).value().jobs.size(), 1U) << "its indexes have what was there";
  EXPECT_EQ(store_->recover().value(), 1U);
  EXPECT_EQ(find("running").attempts.front().outcome, "lost");
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
  EXPECT_THAT(kept.inputs, UnorderedElementsAre(done.id, waiting.id));
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
