// What one client may take: its rates, its streams. Loopback has no such limits, so these clients come through a
// trusted proxy from elsewhere.
#include <gmock/gmock.h>

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

TEST_F(LimitsTest, who_submits_too_fast_is_told_when_to_come_back_and_may_still_ask) {
  serve({"--submission-rate-limit", "3", "--rate-limit", "10"});
  const auto client = from("203.0.113.5");
  std::string id;
  for (int i = 0; i < 3; ++i) {
    const Answer answer = submit(client);
    ASSERT_EQ(answer.status, 201) << answer.body;
    id = Json::parse(answer.body).at("id");
  }
  const Answer refused = submit(client);
  expect_told_to_wait(refused, 429, "the limit is 3 submissions (clouds, uploads and jobs) a minute");
  EXPECT_EQ(testing::code_of(refused), "too_many_requests");
  EXPECT_EQ(call(server_->port(), "POST", "/v1/clouds", "x", client).status, 429) << "a cloud is one, too";
  // Asking is counted apart: 5 of 10 requests are spent.
  for (int i = 0; i < 5; ++i) EXPECT_EQ(call(server_->port(), "GET", "/v1/jobs/" + id, {}, client).status, 200);
  expect_told_to_wait(call(server_->port(), "GET", "/v1/jobs/" + id, {}, client), 429, "10 requests a minute");
  EXPECT_EQ(submit(from("203.0.113.6")).status, 201) << "another client has its own share";
  for (int i = 0; i < 5; ++i) EXPECT_EQ(submit({}).status, 201) << "loopback has no limit";
}

TEST_F(LimitsTest, event_streams_have_places_in_all_and_for_each_client) {
  serve({"--streams", "4", "--streams-per-client", "2", "--workers", "1"});
  // A job that runs while the streams are open.
  const Answer made = call(server_->port(), "POST", "/v1/jobs?method=advancing-front",
                           testing::binary_ply(testing::random_points(300'000, 3)));
  ASSERT_EQ(made.status, 201);
  const std::string target = "/v1/jobs/" + Json::parse(made.body).at("id").get<std::string>() + "/events";
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
  Answer again;
  for (int i = 0; i < 100 && again.status != 200; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    again = follow("203.0.113.7");
  }
  EXPECT_EQ(again.status, 200);
}

}  // namespace
}  // namespace surfaced
