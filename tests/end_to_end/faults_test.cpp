// SPDX-License-Identifier: GPL-3.0-or-later
// The service under real faults: kill -9 of the server (and its workers, which are its threads) and of its children
// at random moments while jobs flow.
#include <gmock/gmock.h>

#include <cstdlib>
#include <iostream>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <thread>

#include "base/sha256.hpp"
#include "support/service_client.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;
using testing::Answer;
using ::testing::AnyOf;
using testing::call;

/// SURFACED_FAULTS=200 for the long form.
int number_of_faults() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody writes the environment
  const char* const text = std::getenv("SURFACED_FAULTS");
  return text == nullptr ? 16 : std::max(1, std::atoi(text));
}

/// One request; status 0 if the server died under it.
Answer ask(std::uint16_t port, const std::string& method, const std::string& target, const std::string& body = {},
           const testing::Fields& fields = {}) {
  try {
    return call(port, method, target, body, fields);
  } catch (const std::exception&) {
    return {};
  }
}

/// A service that is hit again and again, and what it has acknowledged.
class FaultTest : public ::testing::Test {
 protected:
  struct Promise {
    std::string job;
    /// Number of the cloud that it is made from.
    std::size_t cloud = 0;
  };

  void SetUp() override { server_.emplace(data()); }
  std::filesystem::path data() const { return directory_.path() / "data"; }

  /// Sends a cloud, as the body or stored and named, and notes what is acknowledged.
  void submit() {
    const std::size_t cloud = random_() % clouds_.size();
    std::optional<std::string> id;
    if (random_() % 4 == 0) {
      const Answer stored = ask(server_->port(), "POST", "/v1/clouds", clouds_[cloud]);
      if (stored.status != 200 && stored.status != 201) return;
      const Json order{{"method", "advancing-front"}, {"cloud_id", Json::parse(stored.body).at("id")}};
      id = submit(server_->port(), "/v1/jobs", order.dump(), {{"Content-Type", "application/json"}});
    } else {
      id = submit(server_->port(), "/v1/jobs?method=advancing-front", clouds_[cloud]);
    }
    if (id) promises_.push_back({*id, cloud});
  }
  /// The id, if the server said 201.
  static std::optional<std::string> submit(std::uint16_t port, const std::string& target, const std::string& body,
                                           const testing::Fields& fields = {}) {
    const Answer answer = ask(port, "POST", target, body, fields);
    const Json job = answer.status == 201 ? Json::parse(answer.body, nullptr, false) : Json();
    // An answer that was cut off acknowledges nothing.
    return job.is_object() ? std::optional(job.at("id").get<std::string>()) : std::nullopt;
  }
  /// Has an ended job's mesh made in another format, which a child does.
  void ask_for_another_format() {
    if (promises_.empty()) return;
    ask(server_->port(), "GET", "/v1/jobs/" + promises_[random_() % promises_.size()].job + "/outputs/mesh.ply");
  }

  void kill_server() {
    // A request that is under way when the server dies may be acknowledged or not, but nothing else.
    std::optional<std::string> last;
    std::thread client(
        [&, port = server_->port()] { last = submit(port, "/v1/jobs?method=advancing-front", clouds_[0]); });
    std::this_thread::sleep_for(milliseconds(random_() % 8));
    server_->end(SIGKILL);
    client.join();
    if (last) promises_.push_back({*last, 0});
    ++servers_killed_;
    // Also while it brings back what the one before has left.
    if (random_() % 4 == 0) {
      testing::ServerProcess::kill_while_it_starts(data(), milliseconds(random_() % 60));
      ++servers_killed_;
    }
    server_.emplace(data());
  }
  void kill_children() {
    for (const pid_t child : server_->children()) children_killed_ += ::kill(child, SIGKILL) == 0 ? 1 : 0;
  }

  /// Every promise is kept: the job has ended once, and its mesh is what it is said to be.
  void check(const Promise& promise) {
    Json job = testing::wait_for_end(server_->port(), promise.job);
    if (job.at("status") == "failed") {
      // Two kills of its child: it was parked by the rule, and starts anew when asked to.
      EXPECT_EQ(job.at("error").at("code"), "crashed") << job.dump();
      EXPECT_TRUE(job.at("parked").get<bool>()) << job.dump();
      EXPECT_EQ(call(server_->port(), "POST", "/v1/jobs/" + promise.job + "/retry").status, 202);
      ++outcomes_["parked"];
      job = testing::wait_for_end(server_->port(), promise.job);
    }
    ASSERT_EQ(job.at("status"), "successful") << job.dump();
    int done = 0;
    for (const Json& attempt : job.at("attempts")) {
      const std::string outcome = attempt.at("outcome");
      EXPECT_THAT(outcome, AnyOf("done", "lost", "crashed"));
      ++outcomes_[outcome];
      done += outcome == "done" ? 1 : 0;
    }
    EXPECT_EQ(done, 1) << "it ended more than once: " << job.dump();
    const Answer mesh = call(server_->port(), "GET", "/v1/jobs/" + promise.job + "/outputs/mesh.glb");
    ASSERT_EQ(mesh.status, 200);
    Sha256 sha;
    sha.update(std::as_bytes(std::span(mesh.body)));
    EXPECT_EQ(mesh.headers.at("etag"), "\"" + sha.finish() + "\"");
    meshes_[promise.cloud].insert(mesh.body);
    EXPECT_EQ(call(server_->port(), "GET", "/v1/jobs/" + promise.job + "/outputs/mesh.ply").status, 200);
  }

  testing::TemporaryDirectory directory_;
  const std::vector<std::string> clouds_{testing::binary_ply(testing::sphere_points(500)),
                                         testing::binary_ply(testing::sphere_points(2000)),
                                         testing::binary_ply(testing::sphere_points(8000))};
  std::mt19937 random_{20};
  std::optional<testing::ServerProcess> server_;
  std::vector<Promise> promises_;
  int servers_killed_ = 0;
  int children_killed_ = 0;
  std::map<std::string, int> outcomes_;
  std::map<std::size_t, std::set<std::string>> meshes_;
};

TEST_F(FaultTest, after_kills_of_server_and_children_at_random_moments_every_acknowledged_job_has_ended_once) {
  const int faults = number_of_faults();
  while (servers_killed_ + children_killed_ < faults) {
    submit();
    submit();
    if (random_() % 3 == 0) ask_for_another_format();
    std::this_thread::sleep_for(milliseconds(random_() % 60));
    if (random_() % 2 == 0) {
      kill_server();
    } else {
      kill_children();
    }
  }
  for (const Promise& promise : promises_) check(promise);
  for (const auto& [cloud, kinds] : meshes_) EXPECT_EQ(kinds.size(), 1U) << "a cloud gave different meshes";
  EXPECT_GE(promises_.size(), static_cast<std::size_t>(faults) / 2);
  std::cout << "kill -9: server " << servers_killed_ << " times, children " << children_killed_ << "; "
            << promises_.size() << " jobs acknowledged; attempts";
  for (const auto& [outcome, count] : outcomes_) std::cout << " " << outcome << " " << count;
  std::cout << std::endl;
}

}  // namespace
}  // namespace surfaced
