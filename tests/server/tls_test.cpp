// SPDX-License-Identifier: GPL-3.0-or-later
// TLS inside the server's own streams: the handshake, and every guard behind it.
#include "http/tls.hpp"

#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "http/conditional.hpp"
#include "http/problem.hpp"
#include "http/server.hpp"
#include "jobs/job_events.hpp"
#include "support/patience.hpp"
#include "support/temporary_directory.hpp"
#include "support/tls_client.hpp"

namespace surfaced::http {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using testing::Answer;
using testing::eventually;
using ::testing::HasSubstr;
using testing::kForLong;
using testing::kPromptly;
using testing::make_certificate;
using testing::RawConnection;
using testing::seconds_since;
using testing::TlsConnection;

constexpr std::uint64_t kBodyLimit = std::uint64_t{6} << 20;
constexpr std::uint64_t kBig = std::uint64_t{8} << 20;

char byte_at(std::uint64_t offset) { return static_cast<char>('a' + (offset * offset) % 23); }

BodyStream big_body() {
  return {kBig, [](std::uint64_t offset, std::span<std::byte> buffer) {
            for (std::size_t i = 0; i < buffer.size(); ++i) buffer[i] = static_cast<std::byte>(byte_at(offset + i));
            return Result<std::size_t>(buffer.size());
          }};
}

Response stream_of(std::size_t pieces) {
  auto streaming = std::make_shared<StreamingResponse>();
  streaming->interval = milliseconds(10);
  streaming->subscribe = [](const std::function<void()>&) { return std::make_shared<int>(0); };
  streaming->next = [told = std::make_shared<std::size_t>(0), pieces](bool) {
    ++*told;
    return StreamingResponse::Chunk{"data: " + std::to_string(*told) + "\n\n", false, *told == pieces};
  };
  Response response;
  response.content_type = "text/event-stream";
  response.streaming = streaming;
  return response;
}

class TlsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::signal(SIGPIPE, SIG_IGN);
    router_.add("GET", "/hello", [](Request&) { return json_response(200, {{"hello", "you"}}); });
    router_.add("GET", "/big", [](Request& request) {
      return conditional_response(request, "\"big\"", "application/octet-stream", big_body());
    });
    router_.add("GET", "/stream", [](Request&) { return stream_of(5); });
    router_.add("GET", "/wait", [this](Request&) {
      auto deferred = std::make_shared<DeferredResponse>();
      deferred->deadline = steady_clock::now() + kForLong;
      deferred->subscribe = [this](std::function<void()> wake) {
        ++waiters_;
        return events_.subscribe("topic", std::move(wake));
      };
      deferred->poll = [this](bool last) -> std::optional<Response> {
        if (!told_ && !last) return std::nullopt;
        return json_response(200, {{"told", told_.load()}});
      };
      Response response;
      response.deferred = deferred;
      return response;
    });
    router_.add("POST", "/count", [](Request& request) {
      std::uint64_t total = 0;
      bool right = true;
      const Status read = request.body->read([&](std::span<const std::byte> bytes) {
        for (const std::byte byte : bytes) right = right && byte == static_cast<std::byte>(byte_at(total++));
        return Status(Done{});
      });
      return read ? json_response(200, {{"bytes", total}, {"right", right}}) : problem_response(read.error(), request);
    });
    limits_.body_bytes = kBodyLimit;
    limits_.threads = 8;
    limits_.bodies = 6;
    // Whoever tests one of them makes it short.
    limits_.connection.head_time = kForLong;
    limits_.connection.idle_time = kForLong;
    limits_.connection.body_grace = kForLong;
    make_certificate(certificate(), key(), "first");
    tls_ = Tls::load({certificate(), key()}).value();
    start();
  }
  void TearDown() override { server_.reset(); }

  void start() {
    server_ = Server::listen({"127.0.0.1", 0}, limits_, router_, {}, tls_.get()).value();
    const std::string url = server_->url();
    EXPECT_TRUE(url.starts_with("https://")) << url;
    port_ = static_cast<std::uint16_t>(std::stoul(url.substr(url.rfind(':') + 1)));
    server_->start();
  }
  void restart() {
    server_->stop(milliseconds(0));
    start();
  }
  void expect_prompt_hello() const {
    const auto began = steady_clock::now();
    EXPECT_EQ(status_of_hello(), 200);
    EXPECT_LT(seconds_since(began), kPromptly) << "others are given " << kForLong.count() << " ms";
  }
  std::filesystem::path certificate() const { return folder_.path() / "certificate.pem"; }
  std::filesystem::path key() const { return folder_.path() / "key.pem"; }
  std::string code_of(const Answer& answer) const {
    const Json json = Json::parse(answer.body, nullptr, false);
    return json.is_object() ? json.value("code", "") : "";
  }
  int status_of_hello() const {
    TlsConnection connection(port_);
    connection.send("GET /hello HTTP/1.1\r\nHost: h\r\n\r\n");
    return connection.read_answer().status;
  }

  testing::TemporaryDirectory folder_;
  JobEvents events_;
  std::atomic<bool> told_ = false;
  std::atomic<int> waiters_ = 0;
  Router router_;
  ServerLimits limits_;
  std::unique_ptr<Tls> tls_;
  std::unique_ptr<Server> server_;
  std::uint16_t port_ = 0;
};

std::string post_line() { return "POST /count HTTP/1.1\r\nHost: h\r\n"; }

TEST_F(TlsTest, speaks_1_2_and_1_3_and_nothing_older) {
  EXPECT_EQ(TlsConnection(port_, {TLS1_2_VERSION, TLS1_2_VERSION}).version(), "TLSv1.2");
  EXPECT_EQ(TlsConnection(port_, {TLS1_3_VERSION, TLS1_3_VERSION}).version(), "TLSv1.3");
  EXPECT_THROW(TlsConnection(port_, {TLS1_VERSION, TLS1_1_VERSION}), std::runtime_error);
}

TEST_F(TlsTest, of_the_protocols_that_are_offered_http_1_1_is_chosen_or_none) {
  EXPECT_EQ(TlsConnection(port_).protocol(), "");
  EXPECT_EQ(TlsConnection(port_, {TLS1_2_VERSION, TLS1_3_VERSION, "\x02h2\x08http/1.1"}).protocol(), "http/1.1");
  EXPECT_THROW(TlsConnection(port_, {TLS1_2_VERSION, TLS1_3_VERSION, "\x02h2"}), std::runtime_error);
}

TEST_F(TlsTest, bytes_come_through_unchanged_both_ways_on_one_connection) {
  for (const int version : {TLS1_2_VERSION, TLS1_3_VERSION}) {
    TlsConnection connection(port_, {version, version});
    std::string body(5'000'000, '\0');
    for (std::size_t i = 0; i < body.size(); ++i) body[i] = byte_at(i);
    connection.send(post_line() + "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    EXPECT_THAT(connection.read_answer().body, HasSubstr("\"bytes\":5000000,\"right\":true"));
    connection.send(post_line() + "Transfer-Encoding: chunked\r\n\r\n" + "3\r\n" + body.substr(0, 3) +
                    "\r\n0\r\n\r\nGET /big HTTP/1.1\r\nHost: h\r\n\r\n");
    EXPECT_THAT(connection.read_answer().body, HasSubstr("\"bytes\":3,\"right\":true"));
    const Answer big = connection.read_answer();
    ASSERT_EQ(big.body.size(), kBig);
    bool right = true;
    for (std::size_t i = 0; i < big.body.size(); ++i) right = right && big.body[i] == byte_at(i);
    EXPECT_TRUE(right);
    connection.send("GET /big HTTP/1.1\r\nHost: h\r\nRange: bytes=5-6\r\n\r\n");
    EXPECT_EQ(connection.read_answer().body, (std::string{byte_at(5), byte_at(6)}));
  }
}

TEST_F(TlsTest, a_stream_ends_with_a_goodbye_so_that_nothing_can_be_cut_off_unseen) {
  TlsConnection connection(port_);
  connection.send("GET /stream HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_EQ(connection.read_answer().status, 200);
  EXPECT_TRUE(connection.closes());
  EXPECT_TRUE(connection.ended_properly());
}

TEST_F(TlsTest, heads_that_are_too_long_or_trickle_meet_their_limits) {
  TlsConnection wide(port_);
  wide.send("GET /hello HTTP/1.1\r\nHost: h\r\nX: " + std::string(40'000, 'x'));
  EXPECT_EQ(wide.read_answer().status, 431);
  TlsConnection lengthy(port_);
  lengthy.send("GET /" + std::string(9000, 'a') + " HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_EQ(lengthy.read_answer().status, 414);
  limits_.connection.head_time = milliseconds(1500);
  restart();
  TlsConnection slow(port_);
  slow.send("GET /hello HTTP/1.1\r\nHost: h\r\n");
  // A deadline for each byte would never come.
  const auto began = steady_clock::now();
  while (!slow.hears_within(milliseconds(100)) && seconds_since(began) < 60) slow.send("A");
  EXPECT_EQ(slow.read_answer().status, 408);
}

TEST_F(TlsTest, bodies_that_are_too_long_or_trickle_meet_their_limits) {
  TlsConnection declared(port_);
  declared.send(post_line() + "Content-Length: 99999999999\r\n\r\n");
  EXPECT_EQ(declared.read_answer().status, 413);
  TlsConnection chunked(port_);
  chunked.send(post_line() + "Transfer-Encoding: chunked\r\n\r\n");
  const std::string chunk = "10000\r\n" + std::string(0x10000, 'x') + "\r\n";
  for (int i = 0; i < 300 && chunked.send(chunk); ++i) {
  }
  EXPECT_EQ(chunked.read_answer().status, 413);
  limits_.connection.body_grace = milliseconds(500);
  restart();
  TlsConnection slow(port_);
  slow.send(post_line() + "Content-Length: 1000\r\n\r\nabc");
  const Answer answer = slow.read_answer();
  EXPECT_EQ(answer.status, 408);
  EXPECT_EQ(code_of(answer), "request_timeout");
}

TEST_F(TlsTest, an_idle_connection_is_closed_with_a_goodbye) {
  limits_.connection.idle_time = milliseconds(300);
  restart();
  TlsConnection connection(port_);
  connection.send("GET /hello HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_EQ(connection.read_answer().status, 200);
  EXPECT_TRUE(connection.closes());
  EXPECT_TRUE(connection.ended_properly());
}

TEST_F(TlsTest, garbage_in_place_of_a_hello_ends_the_connection_and_nothing_else) {
  for (const std::string& bytes : {std::string(100, '\0'), std::string("\x16\x03\x01\x40\x00 and then nonsense"),
                                   std::string(40'000, '\xff'), std::string("SSH-2.0-OpenSSH_9.2\r\n")}) {
    RawConnection connection(port_);
    connection.send(bytes);
    connection.end();
    EXPECT_TRUE(connection.closes());
  }
  EXPECT_EQ(status_of_hello(), 200);
}

TEST_F(TlsTest, plain_http_is_told_that_this_is_the_wrong_port) {
  RawConnection connection(port_);
  connection.send("GET /hello HTTP/1.1\r\nHost: h\r\n\r\n");
  const Answer answer = connection.read_answer();
  EXPECT_EQ(answer.status, 400);
  EXPECT_EQ(code_of(answer), "invalid_request");
  EXPECT_THAT(answer.body, HasSubstr("HTTPS"));
}

/// Notices whether the server has torn the connection down or ended it.
class WatchedConnection : public RawConnection {
 public:
  using RawConnection::RawConnection;
  bool torn() const { return torn_; }

 private:
  ssize_t receive(char* bytes, std::size_t size) override {
    const ssize_t count = RawConnection::receive(bytes, size);
    torn_ |= count < 0;
    return count;
  }
  bool torn_ = false;
};

TEST_F(TlsTest, plain_http_with_a_body_gets_the_answer_and_an_orderly_end) {
  WatchedConnection connection(port_);
  EXPECT_TRUE(
      connection.send("POST /hello HTTP/1.1\r\nHost: h\r\nContent-Length: 100000\r\n\r\n" + std::string(100'000, 'x')));
  EXPECT_EQ(connection.read_answer().status, 400);
  connection.end();
  EXPECT_TRUE(connection.closes());
  EXPECT_FALSE(connection.torn());
}

/// The first bytes of a client's hello, which promise more.
std::string half_a_hello() { return std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11); }

std::vector<std::unique_ptr<RawConnection>> silent_and_half_hellos(std::uint16_t port, int count) {
  std::vector<std::unique_ptr<RawConnection>> slow;
  for (int i = 0; i < count; ++i) {
    slow.push_back(std::make_unique<RawConnection>(port));
    if (i % 2 == 0) slow.back()->send(half_a_hello());
  }
  return slow;
}

TEST_F(TlsTest, clients_that_do_not_end_their_handshake_keep_nobody_waiting) {
  const auto slow = silent_and_half_hellos(port_, 300);
  expect_prompt_hello();
}

TEST_F(TlsTest, clients_that_do_not_end_their_handshake_are_closed) {
  limits_.connection.head_time = milliseconds(300);
  restart();
  const auto slow = silent_and_half_hellos(port_, 300);
  for (const auto& each : slow) EXPECT_TRUE(each->closes());
  EXPECT_TRUE(eventually([&] { return server_->state().connections == 0; }));
}

TEST_F(TlsTest, when_all_places_are_taken_half_a_handshake_makes_room) {
  limits_.connections = 10;
  restart();
  std::vector<std::unique_ptr<RawConnection>> slow;
  for (int i = 0; i < 15; ++i) {
    slow.push_back(std::make_unique<RawConnection>(port_));
    slow.back()->send(half_a_hello());
  }
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_EQ(status_of_hello(), 200);
  EXPECT_GE(server_->state().turned_away, 5U);
}

TEST_F(TlsTest, keys_that_change_all_the_time_keep_nobody_waiting) {
  TlsConnection restless(port_, {TLS1_3_VERSION, TLS1_3_VERSION});
  std::atomic<bool> over = false;
  std::thread changing([&] {
    for (int i = 0; i < 20'000 && !over && restless.change_keys(); ++i) {
    }
  });
  for (int i = 0; i < 5; ++i) expect_prompt_hello();
  over = true;
  changing.join();
}

TEST_F(TlsTest, clients_that_do_not_read_their_answers_hold_no_thread) {
  std::vector<std::unique_ptr<TlsConnection>> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(std::make_unique<TlsConnection>(port_));
    slow.back()->send("GET /big HTTP/1.1\r\nHost: h\r\n\r\n");
  }
  std::this_thread::sleep_for(milliseconds(100));
  expect_prompt_hello();
  EXPECT_EQ(slow.front()->read_answer().body.size(), kBig) << "who reads at last gets it all";
}

TEST_F(TlsTest, many_wait_for_an_answer_on_eight_threads) {
  std::vector<std::unique_ptr<TlsConnection>> waiting;
  for (int i = 0; i < 100; ++i) {
    waiting.push_back(std::make_unique<TlsConnection>(port_));
    waiting.back()->send("GET /wait HTTP/1.1\r\nHost: h\r\n\r\n");
  }
  ASSERT_TRUE(eventually([&] { return waiters_ == 100; }));
  EXPECT_EQ(status_of_hello(), 200);
  told_ = true;
  events_.changed("topic");
  for (const auto& each : waiting) EXPECT_THAT(each->read_answer().body, HasSubstr("\"told\":true"));
}

TEST_F(TlsTest, stopping_does_not_wait_for_handshakes) {
  std::vector<std::unique_ptr<RawConnection>> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(std::make_unique<RawConnection>(port_));
    slow.back()->send(half_a_hello());
  }
  std::this_thread::sleep_for(milliseconds(50));
  const auto began = steady_clock::now();
  server_->stop(kForLong);
  EXPECT_LT(seconds_since(began), kPromptly);
}

TEST_F(TlsTest, a_new_certificate_is_shown_from_the_next_connection_on_and_a_broken_one_never) {
  TlsConnection before(port_);
  EXPECT_EQ(before.server_name(), "first");
  make_certificate(certificate(), key(), "second");
  ASSERT_TRUE(tls_->reload().ok());
  EXPECT_EQ(TlsConnection(port_).server_name(), "second");
  before.send("GET /hello HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_EQ(before.read_answer().status, 200) << "what was begun goes on";
  make_certificate(certificate(), folder_.path() / "other.pem", "third");
  const Status mixed = tls_->reload();
  ASSERT_FALSE(mixed);
  EXPECT_THAT(mixed.error().detail, HasSubstr("key.pem"));
  std::ofstream(certificate()) << "no certificate";
  ASSERT_FALSE(tls_->reload());
  EXPECT_EQ(TlsConnection(port_).server_name(), "second");
}

TEST_F(TlsTest, files_that_cannot_be_used_are_refused_by_name) {
  const auto refusal = [&](const std::filesystem::path& one, const std::filesystem::path& two) {
    const auto loaded = Tls::load({one, two});
    EXPECT_FALSE(loaded);
    return loaded ? std::string() : loaded.error().detail;
  };
  EXPECT_THAT(refusal("/nowhere.pem", key()), HasSubstr("--tls-certificate /nowhere.pem"));
  EXPECT_THAT(refusal(certificate(), "/nowhere.pem"), HasSubstr("--tls-key /nowhere.pem"));
  EXPECT_THAT(refusal(key(), key()), HasSubstr("--tls-certificate"));
  const auto locked = folder_.path() / "locked.pem";
  make_certificate(folder_.path() / "its.pem", locked, "x", "secret");
  EXPECT_THAT(refusal(folder_.path() / "its.pem", locked), HasSubstr("--tls-key"));
}

}  // namespace
}  // namespace surfaced::http
