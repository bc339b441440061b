// SPDX-License-Identifier: GPL-3.0-or-later
#include "clouds/cloud_store.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <new>

#include "clouds/inspector.hpp"
#include "jobs/sqlite_job_store.hpp"
#include "platform/random.hpp"
#include "support/artifacts_mock.hpp"
#include "support/patience.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class CloudsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto file = directory_.path() / "jobs.sqlite";
    jobs_ = open_sqlite_job_store(file, {}).value();
    clouds_ = open_sqlite_cloud_store(file).value();
  }
  static StoredInput cloud(char digit) { return {std::string(64, digit), 7, std::string(64, digit)}; }
  Job submit(const StoredInput& input, const std::string& owner = "") {
    NewJob job{random_hex<16>(),        "m", nlohmann::ordered_json::object(), input, {"mesh.glb"}, "r", "",
               std::chrono::seconds(60)};
    job.owner = owner;
    return jobs_->submit(job).value();
  }
  void finish(Outcome outcome) {
    const ClaimedJob claimed = **jobs_->claim();
    Ending ending;
    ending.outcome = outcome;
    if (outcome != Outcome::done) ending.error = Error{ErrorCode::method_failed, "why"};
    ASSERT_TRUE(jobs_->settle(claimed.claim(), ending).ok());
  }

  testing::TemporaryDirectory directory_;
  std::unique_ptr<JobStore> jobs_;
  std::unique_ptr<CloudStore> clouds_;
};

TEST_F(CloudsTest, a_cloud_belongs_to_all_who_sent_it_and_goes_with_the_last) {
  EXPECT_TRUE(clouds_->add(cloud('a'), "alice").value().created);
  EXPECT_FALSE(clouds_->add(cloud('a'), "alice").value().created);
  EXPECT_TRUE(clouds_->add(cloud('a'), "bob").value().created);
  const std::string id(64, 'a');
  EXPECT_EQ(clouds_->find(id, "eve").error().code, ErrorCode::cloud_not_found);
  EXPECT_FALSE(clouds_->remove(id, "alice").value()) << "bob has it still";
  EXPECT_EQ(clouds_->find(id, "alice").error().code, ErrorCode::cloud_not_found);
  EXPECT_TRUE(clouds_->remove(id, "bob").value());
  EXPECT_EQ(clouds_->find(id, std::nullopt).error().code, ErrorCode::cloud_not_found);
}

TEST_F(CloudsTest, a_cloud_stays_while_a_job_uses_it_and_is_no_garbage_of_the_job) {
  ASSERT_TRUE(clouds_->add(cloud('b'), "").ok());
  const Job job = submit(cloud('b'));
  EXPECT_TRUE(job.of_stored_cloud());
  EXPECT_EQ(clouds_->remove(std::string(64, 'b'), std::nullopt).error().code, ErrorCode::cloud_in_use);
  EXPECT_THAT(jobs_->kept().value().inputs, ElementsAre(std::string(64, 'b')));
  ASSERT_TRUE(jobs_->dismiss(job.id).ok());
  const Dismissal removal = jobs_->dismiss(job.id).value();
  EXPECT_TRUE(removal.removed);
  EXPECT_THAT(removal.garbage.inputs, IsEmpty());
  EXPECT_TRUE(clouds_->remove(std::string(64, 'b'), std::nullopt).value());
  NewJob late{random_hex<16>(),        "m", nlohmann::ordered_json::object(), cloud('b'), {"mesh.glb"}, "r", "",
              std::chrono::seconds(60)};
  EXPECT_EQ(jobs_->submit(late).error().code, ErrorCode::cloud_not_found);
}

TEST_F(CloudsTest, a_cloud_that_nobody_uses_goes_after_its_time_and_one_that_a_job_names_stays) {
  ASSERT_TRUE(clouds_->add(cloud('d'), "").ok());
  ASSERT_TRUE(clouds_->add(cloud('e'), "").ok());
  const Job job = submit(cloud('e'));
  EXPECT_THAT(clouds_->expire(std::chrono::hours(1)).value(), IsEmpty()) << "both have just been sent";
  EXPECT_THAT(clouds_->expire(std::chrono::seconds(0)).value(), ElementsAre(std::string(64, 'd')));
  EXPECT_EQ(clouds_->find(std::string(64, 'd'), std::nullopt).error().code, ErrorCode::cloud_not_found);
  ASSERT_TRUE(jobs_->dismiss(job.id).ok());
  ASSERT_TRUE(jobs_->dismiss(job.id).value().removed);
  EXPECT_THAT(clouds_->expire(std::chrono::hours(1)).value(), IsEmpty()) << "its job has used it";
  EXPECT_THAT(clouds_->expire(std::chrono::seconds(0)).value(), ElementsAre(std::string(64, 'e')));
}

TEST_F(CloudsTest, what_a_child_found_is_kept) {
  ASSERT_TRUE(clouds_->add(cloud('c'), "").ok());
  EXPECT_EQ(clouds_->next_to_inspect().value(), std::string(64, 'c'));
  ASSERT_TRUE(clouds_->inspected(std::string(64, 'c'), nlohmann::ordered_json{{"points", 3}}).ok());
  EXPECT_EQ(clouds_->find(std::string(64, 'c'), std::nullopt).value().facts.at("points"), 3);
  EXPECT_EQ(clouds_->next_to_inspect().value(), std::nullopt);
  ASSERT_TRUE(clouds_->add(cloud('d'), "").ok());
  ASSERT_TRUE(clouds_->inspected(std::string(64, 'd'), Error{ErrorCode::unknown_format, "why"}).ok());
  EXPECT_EQ(clouds_->find(std::string(64, 'd'), std::nullopt).value().error->code, ErrorCode::unknown_format);
}

TEST_F(CloudsTest, pages_go_from_the_newest_to_the_oldest_and_miss_none) {
  std::vector<std::string> ids;
  for (int i = 0; i < 5; ++i) ids.push_back(submit({random_hex<16>(), 1, "x"}, i % 2 == 0 ? "alice" : "bob").id);
  std::vector<std::string> seen;
  std::optional<std::int64_t> next;
  do {
    const JobPage page = jobs_->list({}, 2, next).value();
    for (const Job& job : page.jobs) seen.push_back(job.id);
    next = page.next;
  } while (next);
  std::ranges::reverse(ids);
  EXPECT_EQ(seen, ids);
  JobFilter alices;
  alices.owner = "alice";
  EXPECT_EQ(jobs_->list(alices, 10, std::nullopt).value().jobs.size(), 3U);
  JobFilter running;
  running.statuses = {JobStatus::running};
  EXPECT_TRUE(jobs_->list(running, 10, std::nullopt).value().jobs.empty());
  EXPECT_EQ(jobs_->holding_of("alice").value().active_jobs, 3U);
}

/// Every job that the filter lets through, in pages of three.
std::vector<std::string> listed(JobStore& jobs, const JobFilter& filter) {
  std::vector<std::string> ids;
  std::optional<std::int64_t> next;
  do {
    const JobPage page = jobs.list(filter, 3, next).value();
    EXPECT_LE(page.jobs.size(), 3U);
    for (const Job& job : page.jobs) ids.push_back(job.id);
    next = page.next;
  } while (next);
  return ids;
}

bool lets_through(const JobFilter& filter, const Job& job) {
  const auto has = [](const auto& list, const auto& value) { return std::ranges::find(list, value) != list.end(); };
  if (filter.owner && *filter.owner != job.owner) return false;
  if (!filter.statuses.empty() && !has(filter.statuses, job.status)) return false;
  if (!filter.methods.empty() && !has(filter.methods, job.method)) return false;
  return std::ranges::all_of(filter.labels, [&](const std::string& label) { return has(job.labels, label); });
}

/// Owners, statuses, methods and labels in all their combinations.
std::vector<JobFilter> filters() {
  using Texts = std::vector<std::string>;
  using enum JobStatus;
  std::vector<JobFilter> all;
  for (const std::vector<JobStatus>& statuses :
       std::vector<std::vector<JobStatus>>{{}, {failed}, {accepted, running}, {successful, failed}}) {
    for (const Texts& methods : std::vector<Texts>{{}, {"b"}, {"c", "a", "c"}, {"z"}}) {
      for (const Texts& labels : std::vector<Texts>{{}, {"x"}, {"y"}, {"xy", "x"}}) {
        for (const char* owner : {"", "alice"}) all.push_back({owner, statuses, methods, labels});
        all.push_back({std::nullopt, statuses, methods, labels});
      }
    }
  }
  return all;
}

TEST_F(CloudsTest, what_is_thrown_while_a_cloud_is_read_costs_no_thread) {
  ::testing::NiceMock<testing::ArtifactsMock> artifacts;
  std::atomic<int> calls = 0;
  ON_CALL(artifacts, input_file(::testing::_)).WillByDefault([&](std::string_view) -> Result<std::filesystem::path> {
    if (++calls == 1) throw std::bad_alloc();
    return Error{ErrorCode::internal_error, "not to be had"};
  });
  ASSERT_TRUE(clouds_->add(cloud('a'), "me").ok());
  const SideTask task(artifacts, {"/nonexistent"}, {});
  CloudInspector inspector(*clouds_, artifacts, task);
  inspector.start();
  EXPECT_TRUE(testing::eventually([&] { return calls > 0; }));
  inspector.wake();
  EXPECT_TRUE(testing::eventually([&] { return calls > 1; }));
}

TEST_F(CloudsTest, pages_by_any_filter_have_the_jobs_that_a_look_at_each_finds) {
  const std::vector<std::string> methods{"a", "b", "c"};
  for (std::size_t i = 0; i < 40; ++i) {
    NewJob job{random_hex<16>(), methods[i * 7 % 3], {}, cloud('a'), {"mesh.glb"}, "r", "", std::chrono::hours(1)};
    job.input.key = job.id;
    job.owner = i % 4 == 0 ? "" : "alice";
    job.labels = {"xy"};
    if (i % 5 == 0) job.labels.insert(job.labels.begin(), "x");
    ASSERT_TRUE(jobs_->submit(job).ok());
    if (i % 3 != 0) finish(i % 2 == 0 ? Outcome::done : Outcome::input_invalid);
    if (i % 9 == 0) jobs_->claim().value();
  }
  std::vector<Job> all;
  for (const std::string& id : listed(*jobs_, {})) all.push_back(jobs_->find(id).value());
  ASSERT_EQ(all.size(), 40U);
  for (const JobFilter& filter : filters()) {
    std::vector<std::string> expected;
    for (const Job& job : all) {
      if (lets_through(filter, job)) expected.push_back(job.id);
    }
    EXPECT_EQ(listed(*jobs_, filter), expected);
  }
}

}  // namespace
}  // namespace surfaced
