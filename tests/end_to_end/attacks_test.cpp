// SPDX-License-Identifier: GPL-3.0-or-later
// What strangers do to a service on the network: the right status, little memory, and others are served meanwhile.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <thread>

#include "support/gzip_files.hpp"
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
  explicit Bystander(std::uint16_t port) : thread_([this, port] { ask(port); }), sleeper_([this] { sleep(); }) {}
  ~Bystander() { end(); }
  /// The longest wait, in seconds, without the longest time for which the machine let nobody run; more than 60 if an
  /// answer was wrong.
  double end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    if (sleeper_.joinable()) sleeper_.join();
    return std::max(0.0, longest_ - overslept_);
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
      longest_ = std::max(longest_.load(), testing::seconds_since(began));
      std::this_thread::sleep_for(milliseconds(20));
    }
  }
  void sleep() {
    while (!stop_) {
      const auto began = std::chrono::steady_clock::now();
      std::this_thread::sleep_for(milliseconds(10));
      overslept_ = std::max(overslept_.load(), testing::seconds_since(began) - 0.010);
    }
  }
  std::atomic<bool> stop_ = false;
  std::atomic<double> longest_ = 0;
  std::atomic<double> overslept_ = 0;
  std::thread thread_;
  std::thread sleeper_;
};

class AttackTest : public ::testing::Test {
 protected:
  void SetUp() override {
    rlimit files{};
    ::getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = files.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &files);
    serve({"--body-limit", "8MiB", "--header-time", "60", "--body-grace", "60"});
  }
  void serve(const std::vector<std::string>& flags) {
    bystander_.reset();
    server_.reset();
    server_.emplace(directory_.path() / "data", flags, directory_.path() / "log");
    bystander_.emplace(server_->port());
    neighbours_.emplace(server_->pid());
  }
  void TearDown() override {
    const double waited = bystander_->end();
    const double others = neighbours_->share();
    const double peak = testing::peak_megabytes(server_->pid());
    // The promise is that of a machine of its own.
    EXPECT_LT(waited, testing::measuring_is_moot() || others > 0.1 ? 20 : 1)
        << "seconds that another client had to wait, while others had " << others << " of the machine";
    if (!testing::measuring_is_moot()) {
      EXPECT_LT(peak, 300);
    }
    EXPECT_EQ(server_->end(SIGTERM), 0);
    // For docs/operations.md.
    std::cout << "| " << ::testing::UnitTest::GetInstance()->current_test_info()->name() << " | " << std::lround(peak)
              << " MB | " << std::lround(waited * 1000) << " ms |"
              << (others > 0.1 ? " beside " + std::to_string(std::lround(others * 100)) + " % of others" : "")
              << std::endl;
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
  std::optional<testing::Neighbours> neighbours_;
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

TEST_F(AttackTest, a_compressed_body_of_256_mib_is_inflated_by_the_child_alone_and_refused) {
  const std::string bomb = testing::gzipped(std::string(std::size_t{256} << 20, '\0'));
  EXPECT_LT(bomb.size(), std::size_t{1} << 20);
  for (const char* coding : {"deflate", "br", "gzip, identity"}) {
    const Answer answer = call(port(), "POST", "/v1/jobs?method=advancing-front", bomb, {{"Content-Encoding", coding}});
    EXPECT_EQ(answer.status, 415) << coding;
    EXPECT_EQ(testing::code_of(answer), "unsupported_content_encoding") << coding;
  }
  for (const char* coding : {"gzip", "x-gzip"}) {
    const Answer answer =
        call(port(), "POST", "/v1/reconstruct?method=advancing-front", bomb, {{"Content-Encoding", coding}});
    EXPECT_EQ(answer.status, 422) << coding;
    EXPECT_EQ(testing::code_of(answer), "unsupported_feature") << coding << answer.body;
  }
  // Of JSON and forms, which the server itself reads, no coding is taken.
  EXPECT_EQ(call(port(), "POST", "/v1/jobs", bomb, {{"Content-Type", "application/json"}, {"Content-Encoding", "gzip"}})
                .status,
            415);
}

TEST_F(AttackTest, json_that_is_deep_or_large_or_wrong_is_refused) {
  const auto post = [&](const std::string& body) {
    return call(port(), "POST", "/v1/jobs", body, {{"Content-Type", "application/json"}});
  };
  EXPECT_EQ(post(std::string(500'000, '[')).status, 400);
  EXPECT_EQ(post("{\"parameters\":" + std::string(200'000, '[') + std::string(200'000, ']') + "}").status, 400);
  EXPECT_EQ(post("\"" + std::string(2'000'000, 'x') + "\"").status, 413);
  EXPECT_EQ(post("{\"ttl_seconds\":-1e400}").status, 400) << "no double holds it";
  for (int i = 0; i < 50; ++i) {
    const Answer answer = post(R"({"method":"advancing-front","cloud_id":7,"parameters":{"beta":"\ud800"}})");
    EXPECT_EQ(answer.status, 400) << answer.body;
  }
}

TEST_F(AttackTest, a_form_of_many_parts_or_without_end_holds_no_memory) {
  const std::string head =
      kPost + "Content-Type: multipart/form-data; boundary=B\r\nTransfer-Encoding: chunked\r\n\r\n";
  const auto send = [&](const std::string& piece) {
    RawConnection connection(port());
    connection.send(head);
    char size[16];
    std::snprintf(size, sizeof size, "%zx\r\n", piece.size());
    for (int i = 0; i < 64 && connection.send(size + piece + "\r\n"); ++i) {
    }
    connection.send("0\r\n\r\n");
    return connection.read_answer().status;
  };
  std::string parts;
  while (parts.size() < (1U << 20)) parts += "--B\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\nx\r\n";
  EXPECT_THAT(send(parts), ::testing::AnyOf(400, 413));
  EXPECT_THAT(send("--B\r\nX: " + std::string(1 << 20, 'x')), ::testing::AnyOf(400, 413));
}

TEST_F(AttackTest, a_client_cannot_say_where_it_comes_from_and_cannot_forge_the_log) {
  for (const char* field : {"REMOTE_ADDR: 8.8.8.8", "X-Forwarded-For: 8.8.8.8", "X: a%0d%0aSet-Cookie: b"}) {
    RawConnection connection(port());
    connection.send("GET /v1/methods HTTP/1.1\r\nHost: h\r\n" + std::string(field) + "\r\n\r\n");
    const Answer answer = connection.read_answer();
    EXPECT_EQ(answer.status, 200);
    EXPECT_FALSE(answer.headers.contains("set-cookie"));
  }
  std::ostringstream log;
  log << std::ifstream(directory_.path() / "log").rdbuf();
  EXPECT_THAT(log.str(), ::testing::HasSubstr("client=\"127.0.0.1\""));
  EXPECT_THAT(log.str(), ::testing::Not(::testing::HasSubstr("8.8.8.8")));
}

TEST_F(AttackTest, pages_of_other_sites_and_names_that_are_rebound_reach_nothing) {
  const auto status = [&](const std::string& line, const std::string& fields) {
    RawConnection connection(port());
    connection.send(line + " HTTP/1.1\r\n" + fields + "Content-Length: 0\r\n\r\n");
    return connection.read_answer().status;
  };
  const std::string deletes = "DELETE /v1/jobs/00000000000000000000000000000000";
  const std::vector<std::pair<std::string, std::string>> hostile = {
      {"GET /v1/jobs", "Host: evil.example\r\n"},
      {"GET /", "Host: evil.example:8080\r\n"},
      {"GET http://evil.example/v1/jobs", "Host: localhost\r\n"},
      {deletes, "Host: localhost\r\nOrigin: https://evil.example\r\n"},
      {deletes, "Host: localhost\r\nOrigin: null\r\n"},
      {"GET /v1/jobs", "Host: localhost\r\nSec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: no-cors\r\n"}};
  for (const auto& [line, fields] : hostile) EXPECT_EQ(status(line, fields), 403) << line << fields;
  EXPECT_EQ(status("GET /v1/jobs", "Host: localhost\r\n"), 200);
  EXPECT_EQ(status("GET http://localhost/v1/jobs", "Host: localhost\r\n"), 200);
  EXPECT_EQ(status(deletes, "Host: localhost\r\nOrigin: http://localhost:80\r\n"), 404);
  serve({"--allowed-hosts", "*"});
  for (const auto& [line, fields] : hostile) EXPECT_NE(status(line, fields), 403) << line << fields;
}

TEST_F(AttackTest, event_streams_and_long_polls_by_the_hundred_leave_room_for_others) {
  const std::string job = "/v1/jobs/" + testing::start_endless_job(*server_, testing::random_points(30'000, 3));
  const Crowd streams = crowd(1600, "GET " + job + "/events HTTP/1.1\r\nHost: h\r\n\r\n");
  const Crowd polls = crowd(300, "GET " + job + "?wait=2 HTTP/1.1\r\nHost: h\r\n\r\n");
  std::map<int, int> statuses;
  for (const auto& each : streams) ++statuses[each->read_answer(true).status];
  EXPECT_EQ(statuses[200], 1500);
  EXPECT_EQ(statuses[503], 100);
  EXPECT_EQ(polls.back()->read_answer().status, 200);
  EXPECT_EQ(call(port(), "DELETE", job).status, 202);
}

TEST_F(AttackTest, long_polls_by_the_thousand_leave_room_for_others) {
  const std::string job = "/v1/jobs/" + testing::start_endless_job(*server_, testing::random_points(30'000, 3));
  const Crowd polls = crowd(1800, "GET " + job + "?wait=60 HTTP/1.1\r\nHost: h\r\n\r\n");
  const auto told = [&] {
    return std::ranges::count_if(polls, [](const auto& each) { return each->hears_within(milliseconds(0)); });
  };
  EXPECT_TRUE(testing::eventually([&] { return told() >= 1400; }));
  EXPECT_EQ(told(), 1400) << "400 have a place to wait";
  for (const auto& each : polls) {
    if (!each->hears_within(milliseconds(0))) continue;
    const Answer answer = each->read_answer();
    EXPECT_EQ(answer.status, 503);
    EXPECT_TRUE(answer.headers.contains("retry-after"));
  }
  EXPECT_EQ(call(port(), "DELETE", job).status, 202);
  EXPECT_TRUE(testing::eventually([&] { return told() == 400; })) << "those are told of the end";
}

TEST_F(AttackTest, meshes_asked_for_in_another_format_by_more_than_there_are_threads_hold_none) {
  std::vector<std::string> jobs;
  for (int i = 0; i < 80; ++i) {
    const Answer made =
        call(port(), "POST", "/v1/jobs?method=advancing-front", testing::binary_ply(testing::sphere_points(50)));
    ASSERT_EQ(made.status, 201) << made.body;
    jobs.push_back(Json::parse(made.body).at("id"));
  }
  testing::wait_for_end(port(), jobs.back());
  Crowd crowd;
  for (const std::string& job : jobs) {
    ASSERT_EQ(testing::wait_for_end(port(), job).at("status"), "successful");
    crowd.push_back(std::make_unique<RawConnection>(port()));
    crowd.back()->send("GET /v1/jobs/" + job + "/outputs/mesh.obj HTTP/1.1\r\nHost: h\r\n\r\n");
  }
  for (const auto& each : crowd) EXPECT_EQ(each->read_answer().status, 200);
}

TEST_F(AttackTest, connections_that_come_and_go_by_the_thousand_are_forgotten) {
  for (int i = 0; i < 10; ++i) {
    const Crowd burst = crowd(500, i % 2 == 0 ? "" : "GET /v1/methods HTTP/1.1\r\nHost: h\r\n\r\n");
    if (i % 2 == 1) {
      EXPECT_EQ(burst.back()->read_answer().status, 200);
    }
  }
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
  std::string lines;
  for (int i = 0; i < 100; ++i) lines += "A: b\r\n";
  for (int i = 0; i < 1000 && count.send(lines); ++i) {
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
  serve({"--body-grace", "3"});
  const Crowd slow = crowd(100, kPost + "Content-Length: 1000000\r\n\r\n");
  for (int i = 0; i < 5; ++i) {
    for (const auto& each : slow) each->send("a");
    std::this_thread::sleep_for(milliseconds(200));
  }
  std::map<int, int> statuses;
  for (const auto& each : slow) ++statuses[each->read_answer().status];
  EXPECT_GE(statuses[503], 30) << "those without a place";
  EXPECT_GE(statuses[408], 48) << "those with a place, when they were too slow";
  EXPECT_EQ(statuses[503] + statuses[408], 100);
}

TEST_F(AttackTest, ranges_that_overlap_and_readers_that_sleep_cost_no_memory) {
  const auto points = testing::torus_points(250, 340);
  const Answer made =
      call(port(), "POST", "/v1/jobs?method=advancing-front&outputs=mesh.stl", testing::binary_ply(points));
  ASSERT_EQ(made.status, 201) << made.body;
  const std::string id = Json::parse(made.body).at("id");
  const Json job = testing::wait_for_end(port(), id);
  ASSERT_EQ(job.at("status"), "successful") << job.dump();
  const std::string mesh = "/v1/jobs/" + id + "/outputs/mesh.stl";
  std::string ranges = "bytes=0-";
  for (int i = 1; i < 500; ++i) ranges += "," + std::to_string(i) + "-";
  const Answer whole = call(port(), "GET", mesh, {}, {{"Range", ranges}});
  EXPECT_EQ(whole.status, 200);
  EXPECT_GT(whole.body.size(), std::size_t{8} << 20);
  const Crowd sleepers = crowd(100, "GET " + mesh + " HTTP/1.1\r\nHost: h\r\n\r\n");
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
