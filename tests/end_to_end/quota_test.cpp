// SPDX-License-Identifier: GPL-3.0-or-later
// Quotas of keys hold, however many ask at once and whatever they say of their length.
#include <gmock/gmock.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <memory>
#include <thread>

#include "support/service_client.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using testing::Answer;
using testing::call;

class QuotaTest : public ::testing::Test {
 protected:
  /// A key with these limits, and the header that shows it.
  testing::Fields make_key(const std::string& limits) const {
    const std::string command = std::string(SURFACED_BINARY) + " keys add " + keys().string() +
                                " --name k --scopes read,submit --requests-per-minute 0 --submissions-per-minute 0 " +
                                limits;
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
    std::string said(4096, '\0');
    said.resize(std::fread(said.data(), 1, said.size(), pipe.get()));
    const std::size_t begin = said.find("sfd_");
    return {{"Authorization", "Bearer " + said.substr(begin, said.find_first_of(" \n", begin) - begin)}};
  }
  std::filesystem::path keys() const { return directory_.path() / "keys.json"; }
  std::filesystem::path data() const { return directory_.path() / "data"; }

  /// A chunked body, with its end or without.
  static Answer send_chunked(std::uint16_t port, const std::string& target, const testing::Fields& key,
                             const std::vector<std::string>& chunks, bool end = true) {
    testing::RawConnection connection(port);
    connection.send("POST " + target + " HTTP/1.1\r\nHost: h\r\nConnection: close\r\n" + key.front().first + ": " +
                    key.front().second + "\r\nTransfer-Encoding: chunked\r\n\r\n");
    for (const std::string& chunk : chunks) {
      std::array<char, 32> size{};
      std::snprintf(size.data(), size.size(), "%zx\r\n", chunk.size());
      if (!connection.send(size.data() + chunk + "\r\n")) break;
    }
    if (end) connection.send("0\r\n\r\n");
    return connection.read_answer();
  }

  testing::TemporaryDirectory directory_;
};

TEST_F(QuotaTest, many_chunked_bodies_at_once_store_no_more_than_the_key_may) {
  const auto key = make_key("--stored-bytes 100KB");
  const testing::ServerProcess server(data(), {"--keys", keys().string()});
  std::atomic<int> stored = 0;
  std::atomic<int> refused = 0;
  std::vector<std::thread> clients;
  for (int i = 0; i < 24; ++i) {
    clients.emplace_back([&, i] {
      const std::string part(15'000, static_cast<char>('a' + i));
      const Answer answer = send_chunked(server.port(), "/v1/clouds", key, {part, part});
      stored += answer.status == 201 ? 1 : 0;
      refused += testing::code_of(answer) == "quota_exceeded" ? 1 : 0;
    });
  }
  for (std::thread& each : clients) each.join();
  EXPECT_LE(stored, 3) << "of 30 kB each";
  EXPECT_EQ(stored + refused, 24);
  const std::filesystem::directory_iterator inputs(data() / "inputs");
  EXPECT_EQ(std::distance(begin(inputs), end(inputs)), stored) << "what was refused is not kept";
}

TEST_F(QuotaTest, a_body_without_a_length_is_refused_where_the_room_ends_and_not_when_it_ends) {
  const auto key = make_key("--stored-bytes 100KB");
  const testing::ServerProcess server(data(), {"--keys", keys().string()});
  for (const char* target : {"/v1/clouds", "/v1/jobs?method=poisson"}) {
    const Answer answer =
        send_chunked(server.port(), target, key, std::vector<std::string>(5, std::string(50'000, 'x')), false);
    EXPECT_EQ(answer.status, 429) << answer.body;
    EXPECT_EQ(testing::code_of(answer), "quota_exceeded");
  }
  EXPECT_TRUE(testing::eventually([&] { return std::filesystem::is_empty(data() / "uploads"); }));
}

TEST_F(QuotaTest, of_many_jobs_at_once_as_many_are_taken_as_may_be_active) {
  const auto key = make_key("--active-jobs 5");
  const testing::ServerProcess server(data(), {"--keys", keys().string(), "--workers", "1"});
  const std::string first = testing::start_endless_job(server, testing::random_points(20'000, 1), key);
  const std::string cloud = testing::binary_ply(testing::sphere_points(100));
  std::atomic<int> taken = 0;
  std::vector<std::thread> clients;
  for (int i = 0; i < 40; ++i) {
    clients.emplace_back([&] {
      const Answer answer = call(server.port(), "POST", "/v1/jobs?method=advancing-front", cloud, key);
      taken += answer.status == 201 ? 1 : 0;
      EXPECT_TRUE(answer.status == 201 || testing::code_of(answer) == "quota_exceeded") << answer.body;
    });
  }
  for (std::thread& each : clients) each.join();
  EXPECT_EQ(taken, 4) << "and the one that runs";
}

TEST_F(QuotaTest, unfinished_uploads_are_bounded) {
  const testing::ServerProcess server(data(), {"--uploads", "3"});
  const testing::Fields fields{{"Tus-Resumable", "1.0.0"}, {"Upload-Length", "10"}};
  std::string last;
  for (int i = 0; i < 3; ++i) {
    const Answer begun = call(server.port(), "POST", "/v1/uploads", "", fields);
    ASSERT_EQ(begun.status, 201);
    last = begun.headers.at("location");
  }
  const Answer refused = call(server.port(), "POST", "/v1/uploads", "", fields);
  EXPECT_EQ(refused.status, 503);
  EXPECT_TRUE(refused.headers.contains("retry-after"));
  EXPECT_EQ(call(server.port(), "DELETE", last, "", {{"Tus-Resumable", "1.0.0"}}).status, 204);
  EXPECT_EQ(call(server.port(), "POST", "/v1/uploads", "", fields).status, 201);
}

}  // namespace
}  // namespace surfaced
