// SPDX-License-Identifier: GPL-3.0-or-later
// The attacks of which cpp-httplib 0.11.4 dies, on the server as it stands behind the guard.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <zlib.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "http/conditional.hpp"
#include "http/problem.hpp"
#include "http/server.hpp"
#include "jobs/job_events.hpp"
#include "support/http_client.hpp"
#include "support/limited_child.hpp"
#include "support/patience.hpp"

namespace surfaced::http {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using testing::Answer;
using testing::call;
using testing::eventually;
using ::testing::HasSubstr;
using testing::kForLong;
using testing::kPromptly;
using ::testing::Not;
using testing::RawConnection;
using testing::seconds_since;

constexpr std::uint64_t kBodyLimit = std::uint64_t{1} << 20;
constexpr milliseconds kHandlerTime{2200};

/// Something that becomes known at some time.
class Topic {
 public:
  std::shared_ptr<void> subscribe(std::function<void()> wake) {
    ++waiters_;
    auto waiter = events_.subscribe("topic", std::move(wake));
    return {nullptr, [this, waiter](void*) mutable {
              waiter.reset();
              --waiters_;
            }};
  }
  void tell() {
    told_ = true;
    events_.changed("topic");
  }
  bool told() const { return told_; }
  std::size_t waiters() const { return waiters_; }

 private:
  JobEvents events_;
  std::atomic<bool> told_ = false;
  std::atomic<std::size_t> waiters_ = 0;
};

class HttpGuardTest : public ::testing::Test {
 protected:
  void SetUp() override {
    router_.add("GET", "/hello", [](Request& request) {
      return json_response(
          200, {{"address", request.remote_address}, {"header", request.headers.find("REMOTE_ADDR").value_or("")}});
    });
    router_.add("GET", "/big", [](Request& request) {
      return conditional_response(request, "\"big\"", "application/octet-stream",
                                  {std::uint64_t{8} << 20, [](std::uint64_t, std::span<std::byte> buffer) {
                                     std::ranges::fill(buffer, std::byte{'b'});
                                     return Result<std::size_t>(buffer.size());
                                   }});
    });
    router_.add("GET", "/late", [](Request& request) {
      std::this_thread::sleep_for(kHandlerTime);
      return conditional_response(request, "\"late\"", "application/octet-stream",
                                  {std::uint64_t{32} << 20, [](std::uint64_t, std::span<std::byte> buffer) {
                                     std::ranges::fill(buffer, std::byte{'l'});
                                     return Result<std::size_t>(buffer.size());
                                   }});
    });
    router_.add("GET", "/wait", [this](Request& request) {
      auto deferred = std::make_shared<DeferredResponse>();
      deferred->deadline = std::chrono::steady_clock::now() + (request.query.empty() ? kForLong : milliseconds(200));
      deferred->subscribe = [this](std::function<void()> wake) { return topic_.subscribe(std::move(wake)); };
      deferred->poll = [this](bool last) -> std::optional<Response> {
        if (!topic_.told() && !last) return std::nullopt;
        return json_response(200, {{"told", topic_.told()}});
      };
      Response response;
      response.deferred = deferred;
      return response;
    });
    router_.add("GET", "/follow", [this](Request& request) {
      auto streaming = std::make_shared<StreamingResponse>();
      streaming->interval = request.query.empty() ? kForLong : milliseconds(100);
      streaming->subscribe = [this](std::function<void()> wake) { return topic_.subscribe(std::move(wake)); };
      streaming->next = [this](bool) { return StreamingResponse::Chunk{++asked_ == 1 ? "first" : "", false, false}; };
      Response response;
      response.streaming = streaming;
      return response;
    });
    router_.add("GET", "/throw", [](Request&) -> Response { throw std::runtime_error("secret"); });
    router_.add("POST", "/ignore", [](Request& request) {
      return problem_response({ErrorCode::not_found, "no"}, request);
    });
    router_.add("POST", "/count", [this](Request& request) {
      std::uint64_t total = 0;
      const Status read = request.body->read([&](std::span<const std::byte> bytes) {
        total += bytes.size();
        return Status(Done{});
      });
      seen_ = total;
      return read ? json_response(200, {{"bytes", total}}) : problem_response(read.error(), request);
    });
    limits_.body_bytes = kBodyLimit;
    limits_.threads = 8;
    limits_.bodies = 6;
    // Whoever tests one of them makes it short.
    limits_.connection.head_time = kForLong;
    limits_.connection.idle_time = kForLong;
    limits_.connection.body_grace = kForLong;
    start();
  }
  void restart() {
    server_->stop(milliseconds(0));
    start();
  }
  void start() {
    server_ = Server::listen({"127.0.0.1", 0}, limits_, router_).value();
    const std::string url = server_->url();
    port_ = static_cast<std::uint16_t>(std::stoul(url.substr(url.rfind(':') + 1)));
    server_->start();
  }
  void expect_prompt_hello() const {
    const auto began = steady_clock::now();
    EXPECT_EQ(call(port_, "GET", "/hello").status, 200);
    EXPECT_LT(seconds_since(began), kPromptly) << "others are given " << kForLong.count() << " ms";
  }
  /// Of this process, client and server, for one request.
  double processor_time_of(const std::string& request) const {
    RawConnection connection(port_);
    const double began = testing::processor_seconds();
    connection.send(request);
    connection.read_answer();
    return testing::processor_seconds() - began;
  }
  std::string code_of(const Answer& answer) const {
    const Json json = Json::parse(answer.body, nullptr, false);
    return json.is_object() ? json.value("code", "") : "";
  }

  Topic topic_;
  Router router_;
  ServerLimits limits_;
  std::unique_ptr<Server> server_;
  std::uint16_t port_ = 0;
  std::atomic<std::uint64_t> seen_ = 0;
  std::atomic<int> asked_ = 0;
};

std::string post_line() { return "POST /count HTTP/1.1\r\nHost: h\r\n"; }

TEST_F(HttpGuardTest, several_requests_use_one_connection) {
  RawConnection connection(port_);
  for (int i = 0; i < 5; ++i) {
    connection.send("GET /hello HTTP/1.1\r\nHost: h\r\n\r\n");
    EXPECT_EQ(connection.read_answer().status, 200);
    connection.send(post_line() + "Content-Length: 3\r\n\r\nabc");
    EXPECT_THAT(connection.read_answer().body, HasSubstr("\"bytes\":3"));
    connection.send(post_line() + "Transfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n2\r\nde\r\n0\r\n\r\n");
    EXPECT_THAT(connection.read_answer().body, HasSubstr("\"bytes\":5"));
  }
}

TEST_F(HttpGuardTest, requests_sent_in_one_piece_are_answered_in_their_order) {
  RawConnection connection(port_);
  connection.send(post_line() + "Content-Length: 3\r\n\r\nabc" + post_line() + "Content-Length: 4\r\n\r\nabcd" +
                  "HEAD /hello HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_THAT(connection.read_answer().body, HasSubstr("\"bytes\":3"));
  EXPECT_THAT(connection.read_answer().body, HasSubstr("\"bytes\":4"));
  const Answer head = connection.read_answer(true);
  EXPECT_EQ(head.status, 200);
  EXPECT_NE(head.headers.at("content-length"), "0");
}

TEST_F(HttpGuardTest, a_length_over_the_limit_is_refused_unread) {
  RawConnection connection(port_);
  connection.send(post_line() + "Content-Length: 99999999999\r\n\r\n");
  const Answer answer = connection.read_answer();
  EXPECT_EQ(answer.status, 413);
  EXPECT_EQ(code_of(answer), "payload_too_large");
  EXPECT_EQ(answer.headers.at("connection"), "close");
}

TEST_F(HttpGuardTest, a_chunked_body_over_the_limit_is_cut_off) {
  RawConnection connection(port_);
  connection.send(post_line() + "Transfer-Encoding: chunked\r\n\r\n");
  const std::string chunk = "10000\r\n" + std::string(0x10000, 'x') + "\r\n";
  for (int i = 0; i < 1024 && connection.send(chunk); ++i) {
  }
  connection.send("0\r\n\r\n");
  const Answer answer = connection.read_answer();
  EXPECT_EQ(answer.status, 413);
  EXPECT_LE(seen_, kBodyLimit);
}

TEST_F(HttpGuardTest, a_gzip_bomb_stays_compressed) {
  std::string bomb(1 << 16, '\0');
  z_stream stream{};
  ASSERT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string zeros(32 << 20, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(zeros.data());
  stream.avail_in = static_cast<uInt>(zeros.size());
  stream.next_out = reinterpret_cast<Bytef*>(bomb.data());
  stream.avail_out = static_cast<uInt>(bomb.size());
  ASSERT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  bomb.resize(stream.total_out);
  deflateEnd(&stream);
  const Answer answer = call(port_, "POST", "/count", bomb, {{"Content-Encoding", "gzip"}});
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(seen_, bomb.size());
}

TEST_F(HttpGuardTest, broken_chunks_are_no_body) {
  for (const char* chunks : {"3\r\nabcd\r\n0\r\n\r\n", "+3\r\nabc\r\n0\r\n\r\n", "0x3\r\nabc\r\n0\r\n\r\n", "zz\r\n",
                             "3\r\nabcX\r\n", "-1\r\n\r\n", "0\r\nTrailer: x\r\n\r\n"}) {
    RawConnection connection(port_);
    connection.send(post_line() + "Transfer-Encoding: chunked\r\n\r\n" + chunks);
    const Answer answer = connection.read_answer();
    EXPECT_EQ(answer.status, 400) << chunks;
    EXPECT_EQ(code_of(answer), "invalid_request") << chunks;
    EXPECT_TRUE(connection.closes()) << chunks;
  }
}

TEST_F(HttpGuardTest, a_body_that_breaks_off_is_no_body) {
  for (const char* rest : {"Content-Length: 10\r\n\r\nabc", "Transfer-Encoding: chunked\r\n\r\n3\r\nab"}) {
    RawConnection connection(port_);
    connection.send(post_line() + rest);
    connection.end();
    EXPECT_EQ(connection.read_answer().status, 400) << rest;
  }
}

TEST_F(HttpGuardTest, length_and_chunks_together_are_refused_and_the_connection_ends) {
  RawConnection connection(port_);
  connection.send(
      post_line() +
      "Content-Length: 3\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET /hello HTTP/1.1\r\nHost: h\r\n\r\n");
  const Answer answer = connection.read_answer();
  EXPECT_EQ(answer.status, 400);
  EXPECT_EQ(answer.headers.at("connection"), "close");
  EXPECT_EQ(connection.read_answer().status, 0);
}

TEST_F(HttpGuardTest, an_unread_body_is_not_taken_for_the_next_request) {
  RawConnection connection(port_);
  connection.send(
      "POST /ignore HTTP/1.1\r\nHost: h\r\nContent-Length: 44\r\n\r\nGET /hello HTTP/1.1\r\nHost: h\r\n\r\nGET /hello");
  EXPECT_EQ(connection.read_answer().status, 404);
  EXPECT_EQ(connection.read_answer().status, 0);
}

TEST_F(HttpGuardTest, endless_headers_end) {
  {
    RawConnection connection(port_);
    connection.send("GET /hello HTTP/1.1\r\nHost: h\r\nX: ");
    const std::string piece(4096, 'x');
    for (int i = 0; i < 64 && connection.send(piece); ++i) {
    }
    EXPECT_EQ(connection.read_answer().status, 431);
  }
  RawConnection connection(port_);
  connection.send("GET /hello HTTP/1.1\r\n");
  std::string lines;
  for (int i = 0; i < 100; ++i) lines += "A: b\r\n";
  for (int i = 0; i < 1000 && connection.send(lines); ++i) {
  }
  EXPECT_EQ(connection.read_answer().status, 431);
}

TEST_F(HttpGuardTest, a_long_request_line_is_too_long) {
  RawConnection connection(port_);
  connection.send("GET /" + std::string(9000, 'a') + " HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_EQ(connection.read_answer().status, 414);
}

TEST_F(HttpGuardTest, headers_that_trickle_meet_one_deadline) {
  limits_.connection.head_time = milliseconds(700);
  restart();
  RawConnection connection(port_);
  connection.send("GET /hello HTTP/1.1\r\nHost: h\r\n");
  // A deadline for each byte would never come.
  const auto began = steady_clock::now();
  while (!connection.hears_within(milliseconds(100)) && seconds_since(began) < 60) connection.send("A");
  const Answer answer = connection.read_answer();
  EXPECT_EQ(answer.status, 408);
  EXPECT_EQ(code_of(answer), "request_timeout");
}

TEST_F(HttpGuardTest, a_body_that_trickles_is_too_slow) {
  limits_.connection.body_grace = milliseconds(500);
  restart();
  RawConnection connection(port_);
  connection.send(post_line() + "Content-Length: 1000\r\n\r\nabc");
  EXPECT_EQ(connection.read_answer().status, 408);
}

TEST_F(HttpGuardTest, an_idle_connection_is_closed_in_silence) {
  limits_.connection.idle_time = milliseconds(300);
  restart();
  RawConnection connection(port_);
  connection.send("GET /hello HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_EQ(connection.read_answer().status, 200);
  EXPECT_TRUE(connection.closes());
}

/// As many connections as a test needs, with the descriptors for both ends.
std::vector<std::unique_ptr<RawConnection>> many_connections(std::uint16_t port, std::size_t count,
                                                             const std::string& bytes) {
  rlimit files{};
  ::getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &files);
  std::vector<std::unique_ptr<RawConnection>> connections;
  connections.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    connections.push_back(std::make_unique<RawConnection>(port));
    if (!bytes.empty()) connections.back()->send(bytes);
  }
  return connections;
}

TEST_F(HttpGuardTest, a_thousand_clients_that_do_not_end_their_head_keep_nobody_waiting) {
  const auto slow = many_connections(port_, 1000, "GET /hello HTTP/1.1\r\n");
  expect_prompt_hello();
}

TEST_F(HttpGuardTest, bodies_that_trickle_leave_threads_for_others_and_more_are_told_to_come_back) {
  const auto slow = many_connections(port_, 20, post_line() + "Content-Length: 1000\r\n\r\nabc");
  expect_prompt_hello();
  const auto told = [&] {
    return std::ranges::count_if(slow, [](const auto& each) { return each->hears_within(milliseconds(0)); });
  };
  EXPECT_TRUE(eventually([&] { return told() >= 14; }));
  EXPECT_EQ(told(), 14) << "six have a place, and time";
  for (const auto& each : slow) {
    if (!each->hears_within(milliseconds(0))) continue;
    const Answer answer = each->read_answer();
    EXPECT_EQ(answer.status, 503);
    EXPECT_TRUE(answer.headers.contains("retry-after"));
  }
}

TEST_F(HttpGuardTest, clients_that_do_not_read_their_answers_hold_no_thread) {
  const auto slow = many_connections(port_, 30, "GET /big HTTP/1.1\r\nHost: h\r\n\r\n");
  std::this_thread::sleep_for(milliseconds(200));
  expect_prompt_hello();
  EXPECT_EQ(slow.front()->read_answer().body.size(), std::size_t{8} << 20) << "who reads at last gets it all";
}

TEST_F(HttpGuardTest, an_answer_that_nobody_takes_is_given_up) {
  limits_.connection.body_grace = milliseconds(500);
  restart();
  const auto slow = many_connections(port_, 1, "GET /big HTTP/1.1\r\nHost: h\r\n\r\n");
  // Past the grace of half a second, and the time that the bytes in the socket's buffers have bought at this pace.
  std::this_thread::sleep_for(milliseconds(100));
  server_->stop(milliseconds(0));
  EXPECT_LT(slow.front()->read_answer(false, milliseconds(2000)).body.size(), std::size_t{8} << 20);
}

TEST_F(HttpGuardTest, when_all_places_are_taken_the_longest_silence_makes_room) {
  limits_.connections = 20;
  restart();
  auto silent = many_connections(port_, 40, "");
  EXPECT_EQ(call(port_, "GET", "/hello").status, 200);
  EXPECT_TRUE(silent.front()->closes());
  silent.back()->send("GET /hello HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_EQ(silent.back()->read_answer().status, 200);
  EXPECT_GE(server_->state().turned_away, 20U);
}

TEST_F(HttpGuardTest, connections_beyond_the_bound_are_answered_503_while_all_others_wait_for_answers) {
  limits_.connections = 20;
  restart();
  const auto waiting = many_connections(port_, 20, "GET /wait HTTP/1.1\r\nHost: h\r\n\r\n");
  ASSERT_TRUE(eventually([&] { return topic_.waiters() == 20; }));
  const Answer refused = call(port_, "GET", "/hello");
  EXPECT_EQ(refused.status, 503);
  EXPECT_TRUE(refused.headers.contains("retry-after"));
  topic_.tell();
  for (const auto& each : waiting) EXPECT_EQ(each->read_answer().status, 200);
  EXPECT_EQ(call(port_, "GET", "/hello").status, 200);
}

TEST_F(HttpGuardTest, hundreds_wait_for_an_answer_on_eight_threads) {
  const auto waiting = many_connections(port_, 300, "GET /wait HTTP/1.1\r\nHost: h\r\n\r\n");
  ASSERT_TRUE(eventually([&] { return topic_.waiters() == 300; }));
  expect_prompt_hello();
  topic_.tell();
  for (const auto& each : waiting) EXPECT_THAT(each->read_answer().body, HasSubstr("\"told\":true"));
  EXPECT_TRUE(eventually([&] { return topic_.waiters() == 0; }));
}

TEST_F(HttpGuardTest, who_waits_for_too_long_is_answered_at_the_deadline_and_can_ask_again) {
  RawConnection connection(port_);
  for (int i = 0; i < 2; ++i) {
    const auto began = std::chrono::steady_clock::now();
    connection.send("GET /wait?soon=1 HTTP/1.1\r\nHost: h\r\n\r\n");
    EXPECT_THAT(connection.read_answer().body, HasSubstr("\"told\":false"));
    EXPECT_GE(std::chrono::steady_clock::now() - began, milliseconds(200));
  }
}

TEST_F(HttpGuardTest, a_waiter_who_goes_away_is_forgotten) {
  {
    const auto waiting = many_connections(port_, 50, "GET /wait HTTP/1.1\r\nHost: h\r\n\r\n");
    ASSERT_TRUE(eventually([&] { return topic_.waiters() == 50; }));
  }
  EXPECT_TRUE(eventually([&] { return topic_.waiters() == 0 && server_->state().connections == 0; }));
}

TEST_F(HttpGuardTest, a_stream_is_asked_after_its_interval_and_else_not) {
  RawConnection connection(port_);
  const auto began = steady_clock::now();
  connection.send("GET /follow?often HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_EQ(connection.read_answer().status, 200);
  EXPECT_TRUE(eventually([&] { return asked_ >= 4; }));
  const int asked = asked_;
  EXPECT_LE(asked, 2 + static_cast<int>(seconds_since(began) / 0.1)) << "once at the beginning, then every 100 ms";
  EXPECT_EQ(topic_.waiters(), 1U) << "it subscribes once";
}

TEST_F(HttpGuardTest, a_stream_is_asked_when_it_is_woken) {
  RawConnection connection(port_);
  connection.send("GET /follow HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_EQ(connection.read_answer().status, 200);
  ASSERT_TRUE(eventually([&] { return topic_.waiters() == 1 && asked_ >= 1; }));
  const int asked = asked_;
  topic_.tell();
  EXPECT_TRUE(eventually([&] { return asked_ > asked; }, kForLong / 2))
      << "its interval is " << kForLong.count() << " ms";
}

TEST_F(HttpGuardTest, stopping_answers_whoever_waits) {
  const auto waiting = many_connections(port_, 20, "GET /wait HTTP/1.1\r\nHost: h\r\n\r\n");
  ASSERT_TRUE(eventually([&] { return topic_.waiters() == 20; }));
  const auto began = steady_clock::now();
  server_->stop(kForLong);
  EXPECT_LT(seconds_since(began), kPromptly);
  for (const auto& each : waiting) {
    const Answer answer = each->read_answer();
    EXPECT_THAT(answer.body, HasSubstr("\"told\":false"));
    EXPECT_EQ(answer.headers.at("connection"), "close");
  }
}

TEST_F(HttpGuardTest, overlapping_ranges_are_not_multiplied) {
  std::string ranges = "bytes=0-";
  for (int i = 1; i < 500; ++i) ranges += "," + std::to_string(i) + "-";
  const Answer answer = call(port_, "GET", "/big", {}, {{"Range", ranges}});
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body.size(), std::size_t{8} << 20);
  const Answer part = call(port_, "GET", "/big", {}, {{"Range", "bytes=5-9"}});
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, "bbbbb");
  EXPECT_EQ(part.headers.at("content-range"), "bytes 5-9/8388608");
  const Answer none = call(port_, "GET", "/big", {}, {{"If-None-Match", "\"big\""}});
  EXPECT_EQ(none.status, 304);
  EXPECT_FALSE(none.headers.contains("content-length"));
  const Answer behind = call(port_, "GET", "/big", {}, {{"Range", "bytes=8388608-"}});
  EXPECT_EQ(behind.status, 416);
  EXPECT_EQ(behind.headers.at("content-range"), "bytes */8388608");
  const Answer head = call(port_, "HEAD", "/big");
  EXPECT_EQ(head.headers.at("content-length"), "8388608");
}

TEST_F(HttpGuardTest, time_that_a_handler_takes_is_not_the_clients) {
  // The handler takes longer than a transfer may stall, and the answer is larger than the socket's buffers; at
  // this pace what fits into those buffers buys no time.
  limits_.connection.body_grace = milliseconds(2000);
  limits_.connection.body_rate = std::uint64_t{256} << 20;
  restart();
  RawConnection connection(port_);
  connection.send("GET /late HTTP/1.1\r\nHost: h\r\n\r\n");
  std::this_thread::sleep_for(kHandlerTime + milliseconds(100));
  EXPECT_EQ(connection.read_answer().body.size(), std::size_t{32} << 20);
}

TEST_F(HttpGuardTest, a_client_cannot_say_where_it_comes_from) {
  const Answer answer = call(port_, "GET", "/hello", {}, {{"REMOTE_ADDR", "10.1.2.3"}});
  EXPECT_THAT(answer.body, HasSubstr(R"("address":"127.0.0.1")"));
  EXPECT_THAT(answer.body, HasSubstr(R"("header":"10.1.2.3")"));
}

TEST_F(HttpGuardTest, an_exception_says_nothing_to_the_client) {
  const Answer answer = call(port_, "GET", "/throw");
  EXPECT_EQ(answer.status, 500);
  EXPECT_EQ(code_of(answer), "internal_error");
  EXPECT_THAT(answer.body, Not(HasSubstr("secret")));
  for (const auto& [name, value] : answer.headers) EXPECT_THAT(value, Not(HasSubstr("secret"))) << name;
}

TEST_F(HttpGuardTest, unknown_paths_and_methods_are_problems_with_allow) {
  EXPECT_EQ(code_of(call(port_, "GET", "/nowhere")), "not_found");
  const Answer wrong = call(port_, "DELETE", "/hello");
  EXPECT_EQ(wrong.status, 405);
  EXPECT_EQ(wrong.headers.at("allow"), "GET, HEAD");
  EXPECT_EQ(call(port_, "PROPFIND", "/hello").status, 405);
  EXPECT_EQ(wrong.headers.at("content-type"), "application/problem+json");
}

TEST_F(HttpGuardTest, bytes_that_are_no_http_get_an_answer_and_the_end) {
  RawConnection connection(port_);
  connection.send(std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xFC\x03\x03\r\n\r\n", 15));
  EXPECT_EQ(connection.read_answer().status, 400);
  EXPECT_TRUE(connection.closes());
}

TEST_F(HttpGuardTest, a_client_that_waits_for_continue_gets_it_only_if_its_body_is_wanted) {
  RawConnection wanted(port_);
  wanted.send(post_line() + "Expect: 100-continue\r\nContent-Length: 3\r\n\r\n");
  std::this_thread::sleep_for(milliseconds(50));
  wanted.send("abc");
  EXPECT_EQ(wanted.read_answer().status, 200);
  RawConnection refused(port_);
  refused.send("POST /ignore HTTP/1.1\r\nHost: h\r\nExpect: 100-continue\r\nContent-Length: 3\r\n\r\n");
  EXPECT_EQ(refused.read_answer().status, 404);
}

TEST_F(HttpGuardTest, stopping_ends_idle_connections_at_once_and_frees_the_port) {
  RawConnection idle(port_);
  const auto began = steady_clock::now();
  server_->stop(kForLong);
  EXPECT_LT(seconds_since(began), kPromptly);
  EXPECT_THROW(RawConnection again(port_), std::runtime_error);
}

TEST(HttpServerTest, an_address_in_use_is_named) {
  const Router router;
  const auto first = Server::listen({"127.0.0.1", 0}, {}, router).value();
  const std::string url = first->url();
  const auto port = static_cast<std::uint16_t>(std::stoul(url.substr(url.rfind(':') + 1)));
  const auto second = Server::listen({"127.0.0.1", port}, {}, router);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::invalid_usage);
  EXPECT_THAT(second.error().detail,
              HasSubstr("127.0.0.1:" + std::to_string(port) + ": cannot listen there: Address already in use"));
}

TEST(HttpServerTest, addresses_are_read_strictly) {
  EXPECT_EQ(parse_address("[::1]:80").value().host, "::1");
  EXPECT_EQ(parse_address("localhost:0").value().port, 0);
  for (const char* text : {"", ":80", "host", "host:", "host:x", "host:65536", "host:-1", "::1:80", "host:80 "}) {
    EXPECT_FALSE(parse_address(text).ok()) << text;
  }
}

TEST_F(HttpGuardTest, chunks_of_one_byte_cost_what_their_bytes_do) {
  std::string chunks;
  while (chunks.size() < kBodyLimit - 16) chunks += "1\r\nx\r\n";
  const std::string request =
      "POST /count HTTP/1.1\r\nHost: h\r\nTransfer-Encoding: chunked\r\n\r\n" + chunks + "0\r\n\r\n";
  const double limit = testing::measuring_is_moot() ? 2 : 0.050;
  EXPECT_LT(testing::best_of_tries(limit, [&] { return processor_time_of(request); }), limit);
  EXPECT_EQ(seen_, chunks.size() / 6);
}

TEST_F(HttpGuardTest, who_takes_nothing_is_cut_off_when_there_is_too_much_and_others_are_not) {
  limits_.unsent.total = std::uint64_t{1} << 20;
  limits_.unsent.patience = milliseconds(200);
  restart();
  std::vector<std::unique_ptr<RawConnection>> sleepers;
  for (int i = 0; i < 40; ++i) {
    sleepers.push_back(std::make_unique<RawConnection>(port_));
    sleepers.back()->send("GET /big HTTP/1.1\r\nHost: h\r\n\r\n");
  }
  EXPECT_TRUE(eventually([&] { return server_->state().cut_off > 0; }));
  EXPECT_TRUE(eventually([&] { return server_->state().unsent_bytes <= limits_.unsent.total; }));
  EXPECT_EQ(call(port_, "GET", "/big").body.size(), std::size_t{8} << 20) << "who takes it gets it all";
  EXPECT_LT(server_->state().connections, 40U);
}

}  // namespace
}  // namespace surfaced::http
