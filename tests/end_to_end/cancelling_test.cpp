// SPDX-License-Identifier: GPL-3.0-or-later
// Cancelling really stops the work, in every method and whatever it is at.
#include <gmock/gmock.h>

#include <cmath>
#include <iostream>

#include "support/limited_child.hpp"
#include "support/service_client.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;
using testing::Answer;
using testing::call;

class CancellingTest : public ::testing::Test {
 protected:
  /// A running job that is past reading, in the middle of the method.
  std::string start_job(const std::string& method, const std::string& cloud) {
    const Answer answer = call(server_.port(), "POST", "/v1/jobs?method=" + method, cloud);
    EXPECT_EQ(answer.status, 201) << answer.body;
    const std::string id = Json::parse(answer.body).at("id");
    testing::wait_for_method(server_.port(), id);
    std::this_thread::sleep_for(milliseconds(300));
    const Json now = testing::job_of(server_.port(), id);
    EXPECT_EQ(now.at("status"), "running") << now.dump();
    EXPECT_EQ(server_.children().size(), 1U);
    phase_ = now.value("phase", "");
    return id;
  }

  testing::TemporaryDirectory directory_;
  const testing::ServerProcess server_{directory_.path() / "data"};
  std::string phase_;
};

TEST_F(CancellingTest, a_running_job_of_two_million_points_is_stopped_within_two_seconds_in_every_method) {
  const std::string cloud =
      testing::binary_ply(testing::random_points(testing::measuring_is_moot() ? 50'000 : 2'000'000, 1));
  const Json list = Json::parse(call(server_.port(), "GET", "/v1/methods").body);
  ASSERT_GE(list.at("methods").size(), 4U);
  for (const Json& each : list.at("methods")) {
    const std::string method = each.at("id");
    const double seconds = testing::best_of_tries(2, [&] {
      const std::string id = start_job(method, cloud);
      const auto began = std::chrono::steady_clock::now();
      EXPECT_EQ(call(server_.port(), "DELETE", "/v1/jobs/" + id).status, 202);
      EXPECT_TRUE(testing::eventually([&] { return server_.children().empty(); }));
      const double took = testing::seconds_since(began);
      // The process may be gone a moment before its outcome is written down.
      EXPECT_TRUE(testing::eventually(
          [&] { return testing::job_of(server_.port(), id).at("attempts").front().at("outcome") == "cancelled"; }));
      return took;
    });
    EXPECT_LT(seconds, 2) << method;
    std::cout << method << " in '" << phase_ << "': stopped after " << std::lround(seconds * 1000) << " ms"
              << std::endl;
  }
}

}  // namespace
}  // namespace surfaced
