// SPDX-License-Identifier: GPL-3.0-or-later
#include "clouds/cloud_store.hpp"

#include <gmock/gmock.h>

#include "jobs/sqlite_job_store.hpp"
#include "platform/random.hpp"
#include "support/temporary_directory.hpp"
#include "webhooks/address_guard.hpp"
#include "webhooks/delivery_store.hpp"
#include "webhooks/sender.hpp"

namespace surfaced {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class CloudsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto file = directory_.path() / "jobs.sqlite";
    jobs_ = open_sqlite_job_store(file, {}).value();
    clouds_ = open_sqlite_cloud_store(file).value();
    deliveries_ = open_sqlite_delivery_store(file).value();
  }
  std::vector<Delivery> due_now(
      std::size_t most, const DeliveryStore::Wanted& wanted = [](const std::string&) { return true; }) {
    return deliveries_->due(most, wanted).value();
  }
  static StoredInput cloud(char digit) { return {std::string(64, digit), 7, std::string(64, digit)}; }
  Job submit(const StoredInput& input, const std::string& owner = "", const std::string& webhook = "") {
    NewJob job{random_hex<16>(),        "m", nlohmann::ordered_json::object(), input, {"mesh.glb"}, "r", "",
               std::chrono::seconds(60)};
    job.owner = owner;
    job.webhook = webhook;
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
  std::unique_ptr<DeliveryStore> deliveries_;
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

TEST_F(CloudsTest, the_end_of_a_job_stands_in_the_outbox_with_its_state) {
  const Job told = submit({random_hex<16>(), 1, "x"}, "", "https://example.org/hook");
  EXPECT_THAT(due_now(10), IsEmpty());
  finish(Outcome::method_failed);
  submit({random_hex<16>(), 1, "x"});
  finish(Outcome::done);
  auto due = due_now(10);
  ASSERT_EQ(due.size(), 1U);
  EXPECT_EQ(due.front().job, told.id);
  due.front().attempts = 1;
  due.front().next_at = now() + std::chrono::hours(1);
  due.front().detail = "nobody there";
  ASSERT_TRUE(deliveries_->tried(due.front()).ok());
  EXPECT_THAT(due_now(10), IsEmpty());
  EXPECT_EQ(deliveries_->of_job(told.id).value().front().detail, "nobody there");
}

TEST_F(CloudsTest, deliveries_that_nobody_waits_for_do_not_stand_in_the_way_of_others) {
  for (const char* url : {"https://slow.example/a", "https://slow.example/b", "https://quick.example/c"}) {
    submit({random_hex<16>(), 1, "x"}, "", url);
    finish(Outcome::done);
  }
  const auto due = due_now(1, [](const std::string& url) { return Receivers::name_of(url) != "slow.example"; });
  ASSERT_EQ(due.size(), 1U);
  EXPECT_EQ(due.front().url, "https://quick.example/c");
}

TEST(ReceiversTest, each_has_one_delivery_at_a_time_and_each_address_its_share) {
  Receivers receivers({4, 2});
  EXPECT_EQ(Receivers::name_of("https://Hook.Example:443/a?b"), Receivers::name_of("https://hook.example"));
  EXPECT_NE(Receivers::name_of("https://hook.example:8443/"), Receivers::name_of("https://hook.example/"));
  for (const char* name : {"a", "b", "c"}) {
    EXPECT_TRUE(receivers.is_free(name));
    receivers.take(name);
    EXPECT_FALSE(receivers.is_free(name));
  }
  EXPECT_EQ(receivers.room(), 1U);
  EXPECT_TRUE(receivers.settle("a", "2001:db8::1"));
  EXPECT_TRUE(receivers.settle("b", "2001:db8::2"));
  EXPECT_FALSE(receivers.settle("c", "2001:db8::3")) << "the third name of one network";
  receivers.leave("c");
  EXPECT_FALSE(receivers.is_free("c")) << "as long as the others are told";
  EXPECT_TRUE(receivers.is_free("d"));
  receivers.leave("a");
  EXPECT_TRUE(receivers.is_free("a"));
  EXPECT_TRUE(receivers.is_free("c"));
  EXPECT_EQ(receivers.room(), 3U);
}

TEST(WebhookTest, nobody_learns_which_names_there_are_here) {
  const std::string inside = resolve_target("https://localhost/", false).error().detail;
  // A label of 64 characters is asked of nobody.
  const std::string unknown = std::string(64, 'a') + ".invalid";
  const std::string nowhere = resolve_target("https://" + unknown + "/", false).error().detail;
  const auto without = [](std::string text, const std::string& name) {
    return text.erase(text.find(name), name.size());
  };
  EXPECT_EQ(without(inside, "localhost"), without(nowhere, unknown));
}

TEST(WebhookTest, only_addresses_that_the_internet_routes_are_public) {
  for (const char* address : {"93.184.216.34", "8.8.8.8", "2606:2800:220:1:248:1893:25c8:1946"}) {
    EXPECT_TRUE(is_public_address(address)) << address;
  }
  for (const char* address : {"127.0.0.1",
                              "10.1.2.3",
                              "172.31.0.1",
                              "192.168.1.1",
                              "169.254.169.254",
                              "100.64.0.1",
                              "0.0.0.0",
                              "224.0.0.1",
                              "255.255.255.255",
                              "198.18.0.1",
                              "::1",
                              "::",
                              "fe80::1",
                              "fc00::1",
                              "ff02::1",
                              "::ffff:127.0.0.1",
                              "64:ff9b::a00:1",
                              "2002:7f00:1::",
                              "2001:db8::1",
                              "2001::1",
                              "localhost",
                              "",
                              "127.1"}) {
    EXPECT_FALSE(is_public_address(address)) << address;
  }
}

TEST(WebhookTest, targets_are_https_and_public) {
  for (const char* url : {"http://8.8.8.8/", "https://user@8.8.8.8/", "https://127.0.0.1/", "https://[::1]/",
                          "https://localhost/", "https://0x7f000001/", "ftp://8.8.8.8/", "nonsense", "https://"}) {
    EXPECT_FALSE(resolve_target(url, false).ok()) << url;
  }
  EXPECT_EQ(resolve_target("https://8.8.8.8/hook", false).value().address, "8.8.8.8");
  EXPECT_EQ(resolve_target("https://127.0.0.1:8443/hook", true).value().port, "8443");
}

TEST(WebhookTest, signatures_are_those_of_the_standard) {
  // echo -n 'id.1.{}' | openssl dgst -sha256 -hmac secret -binary | base64
  EXPECT_EQ(webhook_signature("secret", "id", "1", "{}"), "v1,490pAcC1LQ1k1cOcmH0da199+A88OKCj0Io4WnJlp68=");
  EXPECT_NE(webhook_signature("secret", "id", "1", "{}"), webhook_signature("secret", "id", "2", "{}"));
  EXPECT_EQ(retry_after(1), std::chrono::seconds(5));
  EXPECT_EQ(retry_after(7), std::nullopt);
}

}  // namespace
}  // namespace surfaced
