// SPDX-License-Identifier: GPL-3.0-or-later
// What one client may take: its rates, its streams. Loopback has no such limits, so these clients come through a
// trusted proxy from elsewhere.
#include <gmock/gmock.h>

#include "support/patience.hpp"
#include "support/service_client.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::json;
using testing::Answer;
using testing::call;
using ::testing::HasSubstr;

class LimitsTest : public ::testing::Test {
 protected:
  void serve(std::vector<std::string> flags) {
    flags.insert(flags.end(), {"--trusted-proxies", "127.0.0.1"});
    server_.emplace(directory_.path() / "data", flags);
  }
  static testing::Fields from(const std::string& address) { return {{"X-Forwarded-For", address}}; }
  Answer submit(const testing::Fields& fields) const {
    return call(server_->port(), "POST", "/v1/jobs?method=advancing-front",
                testing::binary_ply(testing::sphere_points(100)), fields);
  }
  void expect_told_to_wait(const Answer& answer, int status, const std::string& limit) const {
    EXPECT_EQ(answer.status, status);
    EXPECT_TRUE(answer.headers.contains("retry-after"));
    EXPECT_THAT(answer.body, HasSubstr(limit));
  }

  testing::TemporaryDirectory directory_;
  std::optional<testing::ServerProcess> server_;
};

TEST_F(LimitsTest, a_line_of_its_own_before_that_of_the_proxy_makes_no_client_local) {
  serve({"--rate-limit", "3"});
  const testing::Fields both = {{"X-Forwarded-For", "127.0.0.1"}, {"X-Forwarded-For", "203.0.113.5"}};
  int taken = 0;
  while (taken < 50 && call(server_->port(), "GET", "/v1/jobs", {}, both).status == 200) ++taken;
  EXPECT_GE(taken, 3);
  EXPECT_LT(taken, 50);
}

TEST_F(LimitsTest, addresses_of_one_customer_of_ipv6_count_together) {
  serve({"--rate-limit", "3"});
  int taken = 0;
  const auto ask = [&] {
    return call(server_->port(), "GET", "/v1/jobs", {}, from("2001:db8:1:2::" + std::to_string(taken))).status;
  };
  while (taken < 50 && ask() == 200) ++taken;
  EXPECT_LT(taken, 50);
  EXPECT_EQ(call(server_->port(), "GET", "/v1/jobs", {}, from("2001:db8:1:3::1")).status, 200);
}

TEST_F(LimitsTest, who_submits_too_fast_is_told_when_to_come_back_and_may_still_ask) {
  serve({"--submission-rate-limit", "3", "--rate-limit", "10"});
  const auto client = from("203.0.113.5");
  // What is spent comes back with time, of which a slow machine takes some.
  const auto began = std::chrono::steady_clock::now();
  const auto come_back = [&](int a_minute) {
    return static_cast<int>(testing::seconds_since(began) / 60 * a_minute) + 1;
  };
  std::string id;
  Answer refused = submit(client);
  int taken = 0;
  for (; refused.status == 201 && taken < 20; ++taken) {
    id = Json::parse(refused.body).at("id");
    refused = submit(client);
  }
  EXPECT_GE(taken, 3);
  EXPECT_LE(taken, 3 + come_back(3));
  expect_told_to_wait(refused, 429, "the limit is 3 submissions (clouds, uploads and jobs) a minute");
  EXPECT_EQ(testing::code_of(refused), "too_many_requests");
  const Answer cloud = call(server_->port(), "POST", "/v1/clouds", "x", client);
  EXPECT_TRUE(cloud.status == 429 || testing::seconds_since(began) > 15) << "a cloud is one, too: " << cloud.status;
  // Asking is counted apart: those above are spent.
  int asked = 0;
  const auto ask = [&] { return call(server_->port(), "GET", "/v1/jobs/" + id, {}, client); };
  for (refused = ask(); refused.status == 200 && asked < 50; ++asked) refused = ask();
  EXPECT_GE(asked, 10 - taken - 2);
  EXPECT_LE(asked, 10 - taken - 2 + come_back(10));
  expect_told_to_wait(refused, 429, "10 requests a minute");
  EXPECT_EQ(submit(from("203.0.113.6")).status, 201) << "another client has its own share";
  for (int i = 0; i < 5; ++i) EXPECT_EQ(submit({}).status, 201) << "loopback has no limit";
}

TEST_F(LimitsTest, event_streams_have_places_in_all_and_for_each_client) {
  serve({"--streams", "4", "--streams-per-client", "2", "--workers", "1"});
  const std::string job = testing::start_endless_job(*server_, testing::random_points(30'000, 3));
  const std::string target = "/v1/jobs/" + job + "/events";
  std::vector<std::unique_ptr<testing::RawConnection>> open;
  const auto follow = [&](const std::string& address) {
    open.push_back(std::make_unique<testing::RawConnection>(server_->port()));
    open.back()->send("GET " + target + " HTTP/1.1\r\nHost: h\r\nX-Forwarded-For: " + address + "\r\n\r\n");
    Answer answer = open.back()->read_answer();
    if (answer.status != 200) open.pop_back();
    return answer;
  };
  EXPECT_EQ(follow("203.0.113.5").status, 200);
  EXPECT_EQ(follow("203.0.113.5").status, 200);
  expect_told_to_wait(follow("203.0.113.5"), 429, "2 event streams are open for 203.0.113.5, the limit is 2");
  EXPECT_EQ(follow("203.0.113.6").status, 200);
  EXPECT_EQ(follow("127.0.0.1").status, 200);
  expect_told_to_wait(follow("127.0.0.1"), 503, "4 event streams are open, the limit is 4");
  // Who goes leaves his place, as soon as the server has noticed.
  open.erase(open.begin());
  EXPECT_TRUE(testing::eventually([&] { return follow("203.0.113.7").status == 200; }));
}

TEST_F(LimitsTest, waits_have_places_in_all_and_for_each_client) {
  serve({"--waits", "4", "--waits-per-client", "2", "--workers", "1"});
  const std::string job = "/v1/jobs/" + testing::start_endless_job(*server_, testing::random_points(30'000, 3));
  std::vector<std::unique_ptr<testing::RawConnection>> waiting;
  // Who is refused is told so at once; who is not can be told only by not hearing anything.
  const auto send = [&](const std::string& request, const std::string& address) -> testing::RawConnection& {
    waiting.push_back(std::make_unique<testing::RawConnection>(server_->port()));
    waiting.back()->send(request + " HTTP/1.1\r\nHost: h\r\nX-Forwarded-For: " + address + "\r\n");
    return *waiting.back();
  };
  const auto poll = [&](const std::string& address) -> testing::RawConnection& {
    testing::RawConnection& connection = send("GET " + job + "?wait=60", address);
    connection.send("\r\n");
    return connection;
  };
  const auto refused = [&](const std::string& address) {
    Answer answer;
    EXPECT_TRUE(testing::eventually([&] {
      testing::RawConnection& connection = poll(address);
      if (!connection.hears_within(std::chrono::milliseconds(500))) return false;
      answer = connection.read_answer();
      return true;
    }));
    return answer;
  };
  expect_told_to_wait(refused("203.0.113.5"), 429, "2 requests wait for an answer for 203.0.113.5, the limit is 2");
  poll("127.0.0.1");
  expect_told_to_wait(refused("127.0.0.1"), 503, "4 requests wait for an answer, the limit is 4");
  // What needs no wait is answered, and who submits gets the job in place of its mesh.
  EXPECT_EQ(call(server_->port(), "GET", job).status, 200);
  EXPECT_EQ(call(server_->port(), "GET", job + "?wait=60", {}, {{"If-None-Match", "\"old\""}}).status, 200);
  const Answer submitted = call(server_->port(), "POST", "/v1/reconstruct?method=advancing-front",
                                testing::binary_ply(testing::sphere_points(100)));
  EXPECT_EQ(submitted.status, 202) << submitted.body;
  EXPECT_TRUE(submitted.headers.contains("location"));
  // Who goes leaves his place, as soon as the server has noticed.
  waiting.clear();
  EXPECT_EQ(call(server_->port(), "DELETE", job).status, 202);
  EXPECT_TRUE(testing::eventually(
      [&] { return call(server_->port(), "GET", submitted.headers.at("location") + "?wait=60").status == 200; }));
}

}  // namespace
}  // namespace surfaced
