// SPDX-License-Identifier: GPL-3.0-or-later
#include "execution/renditions.hpp"

#include <gmock/gmock.h>

#include <latch>
#include <new>

#include "jobs/sqlite_job_store.hpp"
#include "platform/random.hpp"
#include "support/artifacts_mock.hpp"
#include "support/patience.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::_;
using testing::ArtifactsMock;
using ::testing::HasSubstr;
using ::testing::NiceMock;

class RenditionsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ON_CALL(artifacts_, output_file(_, _)).WillByDefault([](const Claim&, std::string_view) {
      return Result<std::filesystem::path>("/mesh.glb");
    });
    ON_CALL(artifacts_, begin_attempt(_)).WillByDefault([](const Claim&) {
      return Result<std::filesystem::path>(Error{ErrorCode::storage_full, "full"});
    });
  }
  Job job_of(const std::string& owner) {
    const std::string id = random_hex<16>();
    NewJob job;
    job.id = id;
    job.method = "m";
    job.parameters = {{"a", 1}};
    job.input.key = id;
    job.wanted = {"mesh.glb", "report.json"};
    job.ttl = std::chrono::hours(1);
    job.owner = owner;
    EXPECT_TRUE(jobs_->submit(job).ok());
    const Claim claim = jobs_->claim().value().value().claim();
    const std::vector<Output> outputs = {{"mesh.glb", 1, 1, "m"}, {"report.json", 1, 1, "r"}};
    EXPECT_TRUE(jobs_->settle(claim, {Outcome::done, std::nullopt, outputs, {}}).ok());
    return jobs_->find(id).value();
  }
  auto order(const Job& job, std::uint32_t number) {
    return renditions_.order(job, "mesh." + std::to_string(number), number);
  }
  /// What became of it.
  Error failure_of(const Renditions::Order& order) {
    if (!testing::eventually([&] { return renditions_.made(order).has_value(); })) {
      return {ErrorCode::timed_out, "nothing became of it"};
    }
    return renditions_.made(order)->error();
  }

  testing::TemporaryDirectory directory_;
  std::unique_ptr<JobStore> jobs_ = open_sqlite_job_store(directory_.path() / "jobs.sqlite", {}).value();
  NiceMock<ArtifactsMock> artifacts_;
  SideTask task_{artifacts_, {"/bin/false"}, {}};
  Renditions renditions_{*jobs_, artifacts_, task_};
};

TEST_F(RenditionsTest, what_is_thrown_ends_the_order_and_not_the_server) {
  EXPECT_CALL(artifacts_, output_file(_, _)).WillRepeatedly([](const Claim&, std::string_view) {
    throw std::bad_alloc();
    return Result<std::filesystem::path>("");
  });
  renditions_.start();
  const Job job = job_of("");
  const auto first = order(job, 1).value();
  EXPECT_EQ(failure_of(*first).code, ErrorCode::internal_error);
  const auto again = order(job, 1).value();
  EXPECT_NE(first, again);
  EXPECT_EQ(failure_of(*again).code, ErrorCode::internal_error);
}

TEST_F(RenditionsTest, no_mesh_is_made_without_the_report_that_belongs_into_it) {
  EXPECT_CALL(artifacts_, open_output(_, std::string_view("report.json"))).WillOnce([](const Claim&, std::string_view) {
    return ArtifactsMock::Reader(Error{ErrorCode::internal_error, "EMFILE"});
  });
  EXPECT_CALL(artifacts_, begin_attempt(_)).Times(0);
  renditions_.start();
  EXPECT_EQ(failure_of(*order(job_of(""), 1).value()).detail, "EMFILE");
}

TEST_F(RenditionsTest, the_jobs_of_one_key_have_a_share_of_the_queue) {
  const Job job = job_of("k");
  std::vector<std::shared_ptr<const Renditions::Order>> held;
  for (std::uint32_t i = 0; i < 32; ++i) held.push_back(order(job, i).value());
  const auto refused = order(job, 32);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::too_many_requests);
  EXPECT_THAT(refused.error().detail, HasSubstr("32 meshes of this key's jobs wait"));
  EXPECT_TRUE(order(job, 31).ok()) << "it is shared";
  EXPECT_TRUE(order(job_of("l"), 1).ok());
  held.pop_back();
  EXPECT_TRUE(order(job, 32).ok()) << "nobody waits for the last one any more";
}

TEST_F(RenditionsTest, all_have_two_hundred_places_and_those_who_have_gone_none) {
  const Job job = job_of("");
  std::vector<std::shared_ptr<const Renditions::Order>> held;
  for (std::uint32_t i = 0; i < 200; ++i) held.push_back(order(job, i).value());
  EXPECT_EQ(order(job, 200).error().code, ErrorCode::not_ready);
  held.clear();
  EXPECT_TRUE(order(job, 200).ok());
}

TEST_F(RenditionsTest, what_somebody_waits_for_is_made_first) {
  const Job left = job_of("");
  const Job job = job_of("");
  for (std::uint32_t i = 0; i < 4; ++i) EXPECT_TRUE(order(left, i).ok());
  const auto awaited = order(job, 4).value();
  const auto too = order(job, 5).value();
  std::latch end(1);
  EXPECT_CALL(artifacts_, output_file(_, _)).WillRepeatedly([&](const Claim& claim, std::string_view) {
    if (claim.job == left.id) end.wait();
    return Result<std::filesystem::path>(Error{ErrorCode::lost, "looked at"});
  });
  renditions_.start();
  EXPECT_EQ(failure_of(*awaited).detail, "looked at");
  EXPECT_EQ(failure_of(*too).detail, "looked at");
  end.count_down();
  renditions_.stop();
}

}  // namespace
}  // namespace surfaced
