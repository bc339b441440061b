// SPDX-License-Identifier: GPL-3.0-or-later
// What ends of jobs leave in the outbox, whose turn it is, and what becomes of a delivery that cannot be made.
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <new>
#include <set>

#include "jobs/sqlite_job_store.hpp"
#include "platform/random.hpp"
#include "support/change_store.hpp"
#include "support/patience.hpp"
#include "support/temporary_directory.hpp"
#include "webhooks/address_guard.hpp"
#include "webhooks/delivery_store.hpp"
#include "webhooks/sender.hpp"

namespace surfaced {
namespace {

using testing::eventually;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Nobody listens there, and only a test may ask.
constexpr const char* kNoListener = "https://127.0.0.1:9/hook";

/// Throws where it is told to, once for each.
class Flaky : public DeliveryStore {
 public:
  explicit Flaky(DeliveryStore& store) : store_(store) {}
  Result<std::vector<Delivery>> due(std::size_t most, const Wanted& wanted) override {
    fail_once(at_due);
    return store_.due(most, wanted);
  }
  Status tried(const Delivery& delivery) override {
    fail_once(at_tried);
    return store_.tried(delivery);
  }
  Result<std::vector<Delivery>> of_job(std::string_view job) override { return store_.of_job(job); }

  std::atomic<bool> at_due = false;
  std::atomic<bool> at_tried = false;

 private:
  static void fail_once(std::atomic<bool>& now) {
    if (now.exchange(false)) throw std::bad_alloc();
  }
  DeliveryStore& store_;
};

class WebhooksTest : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return directory_.path() / "jobs.sqlite"; }
  void SetUp() override {
    jobs_ = open_sqlite_job_store(file(), {}).value();
    deliveries_ = open_sqlite_delivery_store(file()).value();
    flaky_.emplace(*deliveries_);
  }
  /// A job that has ended.
  std::string finish(const std::string& webhook, Outcome outcome = Outcome::done) {
    NewJob job;
    job.id = random_hex<16>();
    job.method = "m";
    job.parameters = nlohmann::ordered_json::object();
    job.input.key = job.id;
    job.wanted = {"mesh.glb"};
    job.ttl = std::chrono::hours(1);
    job.webhook = webhook;
    EXPECT_TRUE(jobs_->submit(job).ok());
    Ending ending;
    ending.outcome = outcome;
    if (outcome != Outcome::done) ending.error = Error{ErrorCode::method_failed, "why"};
    EXPECT_TRUE(jobs_->settle((*jobs_->claim())->claim(), ending).ok());
    return job.id;
  }
  /// Deliveries for as many receivers as there are numbers, `each` for everyone.
  void fill(int receivers, int each) {
    finish("https://first.example/");
    const auto numbers = [](const char* name, int count) {
      return std::string(name) + "(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM " + name + " WHERE n < " +
             std::to_string(count) + ")";
    };
    testing::change_store(
        file(),
        "WITH RECURSIVE " + numbers("r", receivers) + ", " + numbers("e", each) +
            " INSERT INTO deliveries (id, job, url, created_at, next_at) SELECT 'r' || r.n || '-' || e.n, d.job, "
            "'https://r' || r.n || '.example/', d.created_at, d.next_at FROM deliveries d, r, e");
  }
  std::vector<Delivery> due_now(
      std::size_t most, const DeliveryStore::Wanted& wanted = [](const auto&) { return true; }) {
    return deliveries_->due(most, wanted).value();
  }
  Delivery delivery_of(const std::string& job) { return deliveries_->of_job(job).value().front(); }
  /// The delivery once it was tried so often, not waiting for the times of retries.
  Delivery once_tried(const std::string& job, std::uint32_t attempts) {
    testing::change_store(file(), "UPDATE deliveries SET next_at = created_at WHERE status = 'pending'");
    EXPECT_TRUE(eventually([&] { return delivery_of(job).attempts >= attempts; }));
    return delivery_of(job);
  }

  testing::TemporaryDirectory directory_;
  std::unique_ptr<JobStore> jobs_;
  std::unique_ptr<DeliveryStore> deliveries_;
  std::optional<Flaky> flaky_;
};

TEST_F(WebhooksTest, the_end_of_a_job_stands_in_the_outbox_with_its_state) {
  finish("");
  EXPECT_THAT(due_now(10), IsEmpty());
  const std::string told = finish("https://example.org/hook", Outcome::method_failed);
  auto due = due_now(10);
  ASSERT_EQ(due.size(), 1U);
  EXPECT_EQ(due.front().job, told);
  due.front().attempts = 1;
  due.front().next_at = now() + std::chrono::hours(1);
  due.front().detail = "nobody there";
  ASSERT_TRUE(deliveries_->tried(due.front()).ok());
  EXPECT_THAT(due_now(10), IsEmpty());
  EXPECT_EQ(delivery_of(told).detail, "nobody there");
}

TEST_F(WebhooksTest, deliveries_that_nobody_waits_for_do_not_stand_in_the_way_of_others) {
  for (const char* url : {"https://slow.example/a", "https://slow.example/b", "https://quick.example/c"}) finish(url);
  const auto due = due_now(1, [](const std::string& receiver) { return !receiver.starts_with("slow"); });
  ASSERT_EQ(due.size(), 1U);
  EXPECT_EQ(due.front().url, "https://quick.example/c");
}

TEST_F(WebhooksTest, a_receiver_is_the_host_and_port_of_a_url) {
  const auto receiver_of = [&](const std::string& url) { return delivery_of(finish(url)).receiver; };
  const std::string plain = receiver_of("https://hook.example");
  for (const char* url : {"https://Hook.Example:443/a?b", "https://hook.example?x=/", "https://hook.example#f",
                          "https://hook.example/https://other.example/"}) {
    EXPECT_EQ(receiver_of(url), plain) << url;
  }
  for (const char* url : {"https://hook.example:8443/", "https://hook.example:4430", "https://[::443]/"}) {
    EXPECT_NE(receiver_of(url), plain) << url;
  }
}

TEST_F(WebhooksTest, a_look_asks_once_for_each_receiver_however_many_deliveries_wait_for_it) {
  fill(2, 20'000);
  std::size_t asked = 0;
  const auto due = due_now(10, [&](const std::string& receiver) {
    ++asked;
    return !receiver.starts_with("r1.");
  });
  EXPECT_EQ(asked, 3U);
  EXPECT_EQ(due.size(), 2U);
}

TEST_F(WebhooksTest, receivers_get_their_turn_and_a_look_has_a_limit) {
  constexpr int kReceivers = 2'500;
  fill(kReceivers, 1);
  std::size_t asked = 0;
  due_now(10, [&](const auto&) {
    ++asked;
    return false;
  });
  EXPECT_EQ(asked, 1'000U);
  std::set<std::string> seen;
  for (int i = 0; i <= kReceivers / 100; ++i) {
    for (const Delivery& each : due_now(100)) seen.insert(each.receiver);
  }
  EXPECT_EQ(seen.size(), kReceivers + 1U) << "with that of the job itself";
}

TEST_F(WebhooksTest, a_delivery_is_given_up_when_its_job_is_gone_and_not_when_the_store_fails) {
  const std::string kept = finish(kNoListener);
  const std::string removed = finish(kNoListener);
  ASSERT_TRUE(jobs_->dismiss(removed).ok());
  testing::change_store(file(), "ALTER TABLE attempts RENAME TO hidden");
  ASSERT_NE(jobs_->find(kept).error().code, ErrorCode::job_not_found);
  WebhookSender sender(*deliveries_, *jobs_, {"secret", true, ""}, [](const Job&) { return std::string("{}"); });
  sender.start();
  EXPECT_EQ(once_tried(kept, 1).status, "pending");
  testing::change_store(file(), "ALTER TABLE hidden RENAME TO attempts");
  EXPECT_EQ(once_tried(kept, 2).status, "pending") << "nobody listens, which may change";
  EXPECT_TRUE(eventually([&] { return delivery_of(removed).status == "given_up"; }));
  EXPECT_TRUE(delivery_of(kept).next_at.has_value());
}

TEST_F(WebhooksTest, what_is_thrown_in_its_threads_costs_one_attempt_and_no_thread) {
  const std::string job = finish(kNoListener);
  std::atomic<bool> fail = true;
  WebhookSender sender(*flaky_, *jobs_, {"secret", true, ""}, [&](const Job&) -> std::string {
    if (fail) throw std::bad_alloc();
    return "{}";
  });
  flaky_->at_due = true;
  sender.start();
  EXPECT_EQ(once_tried(job, 1).detail, "the request could not be made");
  fail = false;
  flaky_->at_tried = true;
  const Delivery tried = once_tried(job, 2);
  EXPECT_EQ(tried.status, "pending");
  EXPECT_FALSE(flaky_->at_tried || flaky_->at_due) << "nothing was thrown";
  EXPECT_THAT(once_tried(job, 3).detail, HasSubstr("onnect"));
}

TEST(ReceiversTest, each_has_one_delivery_at_a_time_and_each_address_its_share) {
  Receivers receivers({4, 2});
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
