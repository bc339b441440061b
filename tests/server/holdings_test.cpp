// SPDX-License-Identifier: GPL-3.0-or-later
// What keys hold and may hold: counted by every change, decided in the transaction that makes it.
#include <gmock/gmock.h>
#include <sqlite3.h>

#include <array>
#include <atomic>
#include <functional>
#include <random>
#include <thread>

#include "api/incoming.hpp"
#include "artifacts/file_artifact_store.hpp"
#include "base/sha256.hpp"
#include "clouds/cloud_service.hpp"
#include "jobs/sqlite_job_store.hpp"
#include "platform/files.hpp"
#include "platform/random.hpp"
#include "support/temporary_directory.hpp"
#include "uploads/upload_store.hpp"

namespace surfaced {
namespace {

class HoldingsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    JobStoreLimits limits;
    limits.queue = 100'000;
    limits.tombstone = std::chrono::seconds(0);
    limits.patience = std::chrono::seconds(60);
    jobs_ = open_sqlite_job_store(file(), limits).value();
    clouds_ = open_sqlite_cloud_store(file()).value();
    uploads_ = UploadStore::open(directory_.path(), {std::chrono::hours(1)}).value();
    artifacts_ = open_file_artifact_store(directory_.path(), 0).value();
  }
  std::filesystem::path file() const { return directory_.path() / "jobs.sqlite"; }

  static NewJob job(const std::string& owner, std::uint64_t bytes = 10, const std::string& cloud = "") {
    NewJob job;
    job.id = random_hex<16>();
    job.method = "m";
    job.parameters = nlohmann::ordered_json::object();
    job.input = cloud.empty() ? StoredInput{job.id, bytes, "x"} : StoredInput{cloud, bytes, cloud};
    job.wanted = {"mesh.glb"};
    job.ttl = std::chrono::hours(1);
    job.owner = owner;
    return job;
  }
  static StoredInput cloud(char digit, std::uint64_t bytes) {
    return {std::string(64, digit), bytes, std::string(64, digit)};
  }

  /// One change of any kind, to the things of any owner.
  void change_something(std::mt19937& random);
  void end_a_job(std::mt19937& random);
  void change_an_upload(std::mt19937& random, const std::string& owner);

  testing::TemporaryDirectory directory_;
  std::unique_ptr<JobStore> jobs_;
  std::unique_ptr<CloudStore> clouds_;
  std::unique_ptr<UploadStore> uploads_;
  std::unique_ptr<ArtifactStore> artifacts_;
  std::vector<std::string> ids_;
  std::vector<std::string> begun_;
};

void HoldingsTest::end_a_job(std::mt19937& random) {
  const auto claimed = jobs_->claim().value();
  if (!claimed) return;
  Ending ending;
  constexpr auto kOutcomes = std::to_array({Outcome::done, Outcome::lost, Outcome::crashed, Outcome::method_failed});
  ending.outcome = kOutcomes.at(random() % kOutcomes.size());
  if (ending.outcome != Outcome::done) ending.error = Error{ErrorCode::crashed, "why"};
  if (ending.outcome != Outcome::lost) ending.outputs = {{"log.txt", claimed->job.attempt, random() % 100, "x"}};
  ASSERT_TRUE(jobs_->settle(claimed->claim(), ending).ok());
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(jobs_->add_output(claimed->claim(), {"mesh.obj", claimed->job.attempt, random() % 100, "x"}).ok());
  }
}

void HoldingsTest::change_an_upload(std::mt19937& random, const std::string& owner) {
  if (begun_.empty() || random() % 2 == 0) {
    begun_.push_back(uploads_->create({owner}, 1 + random() % 50, "").value().id);
    return;
  }
  auto session = uploads_->begin(begun_[random() % begun_.size()]);
  if (!session) return;
  ASSERT_TRUE(random() % 2 == 0 ? session->remove().ok() : session->became(std::string(64, 'c')).ok());
}

void HoldingsTest::change_something(std::mt19937& random) {
  const std::string owner(1, static_cast<char>('a' + random() % 3));
  const char digit = static_cast<char>('0' + random() % 4);
  const auto any = [&] { return ids_.empty() ? std::string("none") : ids_[random() % ids_.size()]; };
  // What is refused (a cloud in use, a job that is gone) changes nothing, which is right as well.
  switch (random() % 8) {
    case 0:
    case 1: {
      const NewJob next = random() % 3 == 0 ? job(owner, 70, std::string(64, digit)) : job(owner, random() % 30);
      if (jobs_->submit(next).ok()) ids_.push_back(next.id);
      return;
    }
    case 2:
    case 3:
      return end_a_job(random);
    case 4:
      static_cast<void>(jobs_->dismiss(any()).ok());
      static_cast<void>(jobs_->expire().ok());
      return;
    case 5:
      static_cast<void>(jobs_->retry(any()).ok());
      return;
    case 6:
      if (random() % 2 == 0) static_cast<void>(clouds_->remove(std::string(64, digit), owner).ok());
      if (random() % 9 == 0) static_cast<void>(clouds_->expire(std::chrono::seconds(0)).ok());
      static_cast<void>(clouds_->add(cloud(digit, 70), owner).ok());
      return;
    default:
      return change_an_upload(random, owner);
  }
}

TEST_F(HoldingsTest, the_counter_is_what_a_count_from_the_beginning_gives_after_any_changes) {
  std::mt19937 random(16);
  for (int i = 0; i < 1500; ++i) {
    change_something(random);
    if (i % 50 != 0) continue;
    ASSERT_EQ(jobs_->recount_holdings().value(), 0U) << "after change " << i;
  }
  EXPECT_EQ(jobs_->recount_holdings().value(), 0U);
  EXPECT_GT(jobs_->holding_of("a").value().bytes, 0U) << "or nothing was tested";
}

TEST_F(HoldingsTest, a_counter_that_is_wrong_is_found_and_put_right) {
  ASSERT_TRUE(jobs_->submit(job("a", 10)).ok());
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(file().c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "UPDATE holdings SET bytes = 3", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(other);
  EXPECT_EQ(jobs_->recount_holdings().value(), 1U);
  EXPECT_EQ(jobs_->holding_of("a").value().bytes, 10U);
  EXPECT_EQ(jobs_->recount_holdings().value(), 0U);
}

/// Does it in many threads at once, and counts how often it went well.
int at_once(int threads, const std::function<bool(int)>& attempt) {
  std::atomic<int> succeeded = 0;
  std::vector<std::thread> all;
  for (int i = 0; i < threads; ++i) all.emplace_back([&, i] { succeeded += attempt(i) ? 1 : 0; });
  for (std::thread& each : all) each.join();
  return succeeded;
}

TEST_F(HoldingsTest, of_many_at_once_as_many_are_taken_as_the_quota_has_room_for) {
  const Allowance allowance{20, 0};
  EXPECT_EQ(at_once(60, [&](int) { return jobs_->submit(job("a"), allowance).ok(); }), 20);
  EXPECT_EQ(jobs_->submit(job("a"), allowance).error().code, ErrorCode::quota_exceeded);
  EXPECT_TRUE(jobs_->submit(job("b"), allowance).ok()) << "another key's quota is its own";
  const Allowance bytes{0, 1000};
  EXPECT_EQ(at_once(40,
                    [&](int i) {
                      return (i % 2 == 0 ? jobs_->submit(job("c", 90), bytes).ok()
                                         : uploads_->create({"c", "", bytes}, 90, "").ok());
                    }),
            11);
  EXPECT_EQ(clouds_->add(cloud('1', 11), "c", bytes).error().code, ErrorCode::quota_exceeded);
  EXPECT_TRUE(clouds_->add(cloud('1', 10), "c", bytes).ok());
  EXPECT_TRUE(clouds_->add(cloud('1', 10), "c", bytes).ok()) << "it is there already, and adds nothing";
}

TEST_F(HoldingsTest, a_job_that_is_tried_again_counts_as_a_new_one) {
  const Allowance allowance{1, 0};
  const Job first = jobs_->submit(job("a"), allowance).value();
  ASSERT_TRUE(jobs_->dismiss(first.id).ok());
  ASSERT_TRUE(jobs_->submit(job("a"), allowance).ok());
  EXPECT_EQ(jobs_->retry(first.id, allowance).error().code, ErrorCode::quota_exceeded);
}

TEST_F(HoldingsTest, bytes_are_counted_as_they_come_also_without_a_length) {
  api::Incoming incoming(*jobs_);
  const http::Caller caller{"a", false, 0, 1000};
  const std::string piece(400, 'x');
  auto first = incoming.count(artifacts_->begin_upload().value(), caller, 0).value();
  auto second = incoming.count(artifacts_->begin_upload().value(), caller, 0).value();
  EXPECT_TRUE(first->write(as_bytes(piece)).ok());
  EXPECT_TRUE(second->write(as_bytes(piece)).ok());
  EXPECT_EQ(first->write(as_bytes(piece)).error().code, ErrorCode::quota_exceeded);
  EXPECT_EQ(incoming.count(artifacts_->begin_upload().value(), caller, 400).error().code, ErrorCode::quota_exceeded);
  second.reset();
  EXPECT_TRUE(first->write(as_bytes(piece)).ok()) << "what was given up does not count";
  ASSERT_TRUE(jobs_->submit(job("a", 300)).ok());
  EXPECT_EQ(first->write(as_bytes(piece)).error().code, ErrorCode::quota_exceeded) << "with what is stored meanwhile";
}

TEST_F(HoldingsTest, a_cloud_whose_bytes_were_lost_is_stored_again_when_it_is_sent_again) {
  const SideTask task(*artifacts_, {"/bin/false"}, {});
  CloudInspector inspector(*clouds_, *artifacts_, task);
  CloudService service(*clouds_, *artifacts_, inspector);
  const auto send = [&] {
    auto upload = artifacts_->begin_upload().value();
    EXPECT_TRUE(upload->write(as_bytes("some points")).ok());
    return service.add(*upload, "a").value();
  };
  const std::string id = send().cloud.id;
  const auto stored = directory_.path() / "inputs" / id;
  for (const bool truncated : {false, true}) {
    if (truncated) std::filesystem::resize_file(stored, 3);
    if (!truncated) std::filesystem::remove(stored);
    EXPECT_FALSE(send().created);
    EXPECT_EQ(sha256_of_file(open_regular(stored).value().get()).value(), id);
  }
}

}  // namespace
}  // namespace surfaced
