// What strangers do to a service on the network: the right status, little memory, and others are served meanwhile.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <atomic>
#include <optional>
#include <thread>

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
using testing::RawConnection;

using Crowd = std::vector<std::unique_ptr<RawConnection>>;

/// A client that asks for something small all the time, and notes how long it had to wait.
class Bystander {
 public:
  explicit Bystander(std::uint16_t port) : thread_([this, port] { ask(port); }) {}
  ~Bystander() { end(); }
  /// The longest wait, in seconds; more than 60 if an answer was wrong.
  double end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return longest_;
  }

 private:
  void ask(std::uint16_t port) {
    while (!stop_) {
      const auto began = std::chrono::steady_clock::now();
      try {
        if (call(port, "GET", "/v1/methods").status != 200) longest_ = 1000;
      } catch (const std::exception&) {
        longest_ = 2000;
      }
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
      longest_ = std::max(longest_.load(), seconds);
      std::this_thread::sleep_for(milliseconds(20));
    }
  }
  std::atomic<bool> stop_ = false;
  std::atomic<double> longest_ = 0;
  std::thread thread_;
};

class AttackTest : public ::testing::Test {
 protected:
  void SetUp() override {
    rlimit files{};
    ::getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = files.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &files);
    server_.emplace(directory_.path() / "data",
                    std::vector<std::string>{"--body-limit", "8MiB", "--header-time", "5", "--body-grace", "3"});
    bystander_.emplace(server_->port());
  }
  void TearDown() override {
    EXPECT_LT(bystander_->end(), testing::measuring_is_moot() ? 10 : 1) << "seconds that another client had to wait";
    if (!testing::measuring_is_moot()) {
      EXPECT_LT(testing::peak_megabytes(server_->pid()), 300);
    }
    EXPECT_EQ(server_->end(SIGTERM), 0);
  }
  std::uint16_t port() const { return server_->port(); }
  Crowd crowd(std::size_t size, const std::string& bytes) const {
    Crowd connections;
    for (std::size_t i = 0; i < size; ++i) {
      connections.push_back(std::make_unique<RawConnection>(port()));
      if (!bytes.empty()) connections.back()->send(bytes);
    }
    return connections;
  }

  testing::TemporaryDirectory directory_;
  std::optional<testing::ServerProcess> server_;
  std::optional<Bystander> bystander_;
};

const std::string kPost = "POST /v1/jobs?method=advancing-front HTTP/1.1\r\nHost: h\r\n";

TEST_F(AttackTest, a_chunked_body_of_64_mib_stops_at_the_limit) {
  RawConnection connection(port());
  connection.send(kPost + "Transfer-Encoding: chunked\r\n\r\n");
  const std::string chunk = "100000\r\n" + std::string(1 << 20, 'x') + "\r\n";
  for (int i = 0; i < 64 && connection.send(chunk); ++i) {
  }
  const Answer answer = connection.read_answer();
  EXPECT_EQ(answer.status, 413);
  EXPECT_EQ(testing::code_of(answer), "payload_too_large");
  EXPECT_TRUE(std::filesystem::is_empty(directory_.path() / "data/inputs"));
  EXPECT_TRUE(std::filesystem::is_empty(directory_.path() / "data/uploads"));
}

TEST_F(AttackTest, a_compressed_body_is_not_inflated) {
  const Answer answer = call(port(), "POST", "/v1/jobs?method=advancing-front", std::string(1 << 18, '\x1f'),
                             {{"Content-Encoding", "gzip"}});
  EXPECT_EQ(answer.status, 415);
}

TEST_F(AttackTest, headers_without_end_end) {
  RawConnection line(port());
  line.send("GET /v1/methods HTTP/1.1\r\nX: ");
  const std::string piece(1 << 16, 'x');
  for (int i = 0; i < 1000 && line.send(piece); ++i) {
  }
  EXPECT_EQ(line.read_answer().status, 431);
  RawConnection count(port());
  count.send("GET /v1/methods HTTP/1.1\r\nHost: h\r\n");
  for (int i = 0; i < 100'000 && count.send("A: b\r\n"); ++i) {
  }
  EXPECT_EQ(count.read_answer().status, 431);
}

TEST_F(AttackTest, two_thousand_clients_that_never_finish_their_headers_keep_nobody_out) {
  const Crowd slow = crowd(2000, "GET /v1/methods HTTP/1.1\r\nHost: h\r\nX: ");
  for (int i = 0; i < 5; ++i) {
    for (const auto& each : slow) each->send("a");
    std::this_thread::sleep_for(milliseconds(200));
  }
  EXPECT_EQ(call(port(), "GET", "/healthz").status, 200);
}

TEST_F(AttackTest, a_hundred_bodies_that_trickle_take_no_thread_from_others) {
  const Crowd slow = crowd(100, kPost + "Content-Length: 1000000\r\n\r\n");
  for (int i = 0; i < 5; ++i) {
    for (const auto& each : slow) each->send("a");
    std::this_thread::sleep_for(milliseconds(200));
  }
  std::map<int, int> statuses;
  for (const auto& each : slow) ++statuses[each->read_answer(false, milliseconds(8000)).status];
  EXPECT_GE(statuses[503], 30) << "those without a place";
  EXPECT_GE(statuses[408], 48) << "those with a place, when they were too slow";
  EXPECT_EQ(statuses[503] + statuses[408], 100);
}

TEST_F(AttackTest, ranges_that_overlap_and_readers_that_sleep_cost_no_memory) {
  const auto points = testing::torus_points(200, 300);
  const Answer made = call(port(), "POST", "/v1/jobs?method=advancing-front", testing::binary_ply(points));
  ASSERT_EQ(made.status, 201) << made.body;
  const std::string id = Json::parse(made.body).at("id");
  const Json job = testing::wait_for_end(port(), id);
  ASSERT_EQ(job.at("status"), "successful") << job.dump();
  const std::string mesh = "/v1/jobs/" + id + "/outputs/mesh.glb";
  std::string ranges = "bytes=0-";
  for (int i = 1; i < 500; ++i) ranges += "," + std::to_string(i) + "-";
  const Answer whole = call(port(), "GET", mesh, {}, {{"Range", ranges}});
  EXPECT_EQ(whole.status, 200);
  EXPECT_GT(whole.body.size(), std::size_t{1} << 20);
  const Crowd sleepers = crowd(300, "GET " + mesh + " HTTP/1.1\r\nHost: h\r\n\r\n");
  std::this_thread::sleep_for(milliseconds(1000));
  EXPECT_EQ(sleepers.back()->read_answer().body, whole.body) << "who wakes up gets it all";
}

TEST_F(AttackTest, what_two_readers_could_understand_differently_is_refused) {
  for (const char* head :
       {"Content-Length: 4\r\nTransfer-Encoding: chunked\r\n", "Content-Length: 4\r\nContent-Length: 5\r\n",
        "Transfer-Encoding: chunked, identity\r\n", "Content-Length: +4\r\n"}) {
    RawConnection connection(port());
    connection.send(kPost + head + "\r\n0\r\n\r\n");
    EXPECT_EQ(connection.read_answer().status, 400) << head;
  }
}

TEST_F(AttackTest, a_flood_of_requests_is_answered_or_told_to_come_back) {
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      RawConnection connection(port());
      for (int i = 0; i < 200; ++i) {
        connection.send("GET /v1/jobs/00000000000000000000000000000000 HTTP/1.1\r\nHost: h\r\n\r\n");
        const int status = connection.read_answer().status;
        if (status != 404 && status != 503) ++wrong;
      }
    });
  }
  for (auto& each : threads) each.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace surfaced
