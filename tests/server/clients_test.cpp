// SPDX-License-Identifier: GPL-3.0-or-later
// Who a client is (behind proxies, by network), and which pages of browsers may call.
#include <gmock/gmock.h>

#include "access/browser_guard.hpp"
#include "access/client_address.hpp"
#include "http/permits.hpp"
#include "platform/network.hpp"

namespace surfaced {
namespace {

using ::testing::HasSubstr;

std::string client(const std::string& connection, const std::vector<std::string>& lines,
                   const std::string& trusted = "127.0.0.1,10.0.0.0/8,2001:db8:1::/48") {
  http::Headers headers;
  for (const std::string& line : lines) headers.add("X-Forwarded-For", line);
  return client_address(connection, headers, networks_in(trusted).value());
}

TEST(ClientAddressTest, is_that_of_the_connection_unless_a_trusted_proxy_speaks) {
  EXPECT_EQ(client("203.0.113.9", {"127.0.0.1"}), "203.0.113.9");
  EXPECT_EQ(client("127.0.0.1", {}), "127.0.0.1");
  EXPECT_EQ(client("127.0.0.1", {"203.0.113.5"}), "203.0.113.5");
  EXPECT_EQ(client("::ffff:10.9.8.7", {"203.0.113.5"}), "203.0.113.5") << "a mapped address is the same address";
  EXPECT_EQ(client("2001:db8:1:2::3", {"2a00::1"}), "2a00::1");
}

TEST(ClientAddressTest, all_lines_are_one_list_that_is_read_from_the_right) {
  EXPECT_EQ(client("127.0.0.1", {"127.0.0.1", "203.0.113.5"}), "203.0.113.5")
      << "the first line is the client's own, the second the proxy's";
  EXPECT_EQ(client("127.0.0.1", {"127.0.0.1, 198.51.100.7", "203.0.113.5, 10.0.0.2", "10.0.0.1"}), "203.0.113.5");
  EXPECT_EQ(client("127.0.0.1", {"198.51.100.7", "10.0.0.1"}), "198.51.100.7");
  EXPECT_EQ(client("127.0.0.1", {"203.0.113.5", "", " ,, "}), "203.0.113.5") << "empty entries say nothing";
  EXPECT_EQ(client("127.0.0.1", {"10.0.0.3, 10.0.0.2"}), "10.0.0.3") << "all are trusted: the farthest";
}

TEST(ClientAddressTest, nobody_who_comes_by_way_of_another_machine_is_on_this_one) {
  for (const char* line : {"::1, 10.1.2.3", "127.0.0.5, 10.1.2.3", "127.0.0.1", "[::1]:80"}) {
    EXPECT_EQ(client("10.0.0.1", {line}), "unknown") << line;
  }
}

TEST(ClientAddressTest, ports_are_left_away_and_what_is_no_address_is_unknown) {
  EXPECT_EQ(client("127.0.0.1", {"203.0.113.5:4711"}), "203.0.113.5");
  EXPECT_EQ(client("127.0.0.1", {"[2a00::1]:4711"}), "2a00::1");
  for (const char* line : {"localhost", "127.0.0.1.evil", "unknown", "_hidden", "[", "[]", "1.2.3", "127.1", ":"}) {
    EXPECT_EQ(client("127.0.0.1", {line}), "unknown") << line;
    EXPECT_FALSE(is_loopback(client("127.0.0.1", {line}))) << line;
  }
}

TEST(NetworkTest, holds_the_addresses_that_begin_as_it_does) {
  const auto holds = [](const char* network, const char* address) {
    return Network::parse(network).value().holds(address_in(address).value());
  };
  EXPECT_TRUE(holds("10.0.0.0/8", "10.255.1.2"));
  EXPECT_FALSE(holds("10.0.0.0/8", "11.0.0.0"));
  EXPECT_TRUE(holds("192.0.2.128/25", "192.0.2.200"));
  EXPECT_FALSE(holds("192.0.2.128/25", "192.0.2.100"));
  EXPECT_TRUE(holds("0.0.0.0/0", "192.0.2.100"));
  EXPECT_FALSE(holds("0.0.0.0/0", "2001:db8::1")) << "of the other family";
  EXPECT_TRUE(holds("2001:db8::/33", "2001:db8:7fff::1"));
  EXPECT_FALSE(holds("2001:db8::/33", "2001:db8:8000::1"));
  for (const char* wrong :
       {"", "/8", "10.0.0.0/", "10.0.0.0/33", "10.0.0.0/-1", "::/129", "1.1.1.1/4294967200", "host/8", "10.0.0.0/8 "}) {
    EXPECT_FALSE(Network::parse(wrong)) << wrong;
  }
  EXPECT_THAT(networks_in("10.0.0.1, proxy.example").error().detail, HasSubstr("'proxy.example'"));
}

TEST(ClientGroupTest, counts_ipv6_by_64_bits_and_everything_else_as_it_is) {
  EXPECT_EQ(client_group("2001:db8:1:2:3:4:5:6"), client_group("2001:db8:1:2::ffff"));
  EXPECT_NE(client_group("2001:db8:1:2::1"), client_group("2001:db8:1:3::1"));
  EXPECT_EQ(client_group("::ffff:203.0.113.5"), "203.0.113.5");
  EXPECT_EQ(client_group("::1"), "::1");
  EXPECT_EQ(client_group("a1b2c3d4"), "a1b2c3d4") << "the id of a key";
}

TEST(ClientGroupTest, a_customer_of_ipv6_has_one_share_of_the_places) {
  http::Permits permits("things are held", 100, 2);
  const auto first = permits.acquire("2001:db8:1:2::1");
  const auto second = permits.acquire("2001:db8:1:2::2");
  EXPECT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(permits.acquire("2001:db8:1:2:ffff::3").error().code, ErrorCode::too_many_requests);
  EXPECT_TRUE(permits.acquire("2001:db8:1:3::1").ok());
}

using Fields = std::vector<std::pair<std::string, std::string>>;

bool admits(const BrowserGuard& guard, const std::string& method, const Fields& fields) {
  http::Request request;
  request.method = method;
  for (const auto& [name, value] : fields) request.headers.add(name, value);
  const auto refused = guard.refuse(request);
  if (refused) {
    EXPECT_EQ(refused->code, ErrorCode::forbidden);
  }
  return !refused;
}

TEST(BrowserGuardTest, names_that_a_strangers_dns_may_answer_for_are_refused) {
  const BrowserGuard guard({"mesh.example"}, {});
  for (const char* host :
       {"localhost", "localhost:8080", "LOCALHOST", "app.localhost:80", "127.0.0.1:8080", "[::1]:8080", "192.168.1.5",
        "workstation:8080", "mesh.example", "Mesh.Example:8080", "localhost."}) {
    EXPECT_TRUE(admits(guard, "GET", {{"Host", host}})) << host;
  }
  for (const char* host : {"evil.example", "evil.example:8080", "127.0.0.1.evil.example", "localhost.evil.example",
                           "ai.", "notlocalhost.example", "mesh.example.evil", "evillocalhost.", "0x7f.1"}) {
    EXPECT_FALSE(admits(guard, "GET", {{"Host", host}})) << host;
  }
}

TEST(BrowserGuardTest, pages_of_other_sites_are_refused) {
  const BrowserGuard guard({}, {"https://app.example"});
  const std::string own = "localhost:8080";
  EXPECT_TRUE(admits(guard, "POST", {{"Host", own}})) << "no browser";
  EXPECT_TRUE(admits(guard, "POST", {{"Host", own}, {"Origin", "http://localhost:8080"}}));
  EXPECT_TRUE(admits(guard, "POST", {{"Host", own}, {"Origin", "http://localhost:5173"}})) << "the same site";
  EXPECT_TRUE(admits(guard, "POST", {{"Host", "[::1]:8080"}, {"Origin", "http://[::1]:8080"}}));
  EXPECT_TRUE(
      admits(guard, "POST", {{"Host", own}, {"Origin", "https://app.example"}, {"Sec-Fetch-Site", "cross-site"}}));
  for (const char* origin : {"https://evil.example", "null", "http://localhost.evil.example", "http://127.0.0.1:8080",
                             "file://", "localhost:8080", "https://app.example.evil"}) {
    EXPECT_FALSE(admits(guard, "POST", {{"Host", own}, {"Origin", origin}})) << origin;
  }
  EXPECT_FALSE(admits(guard, "GET", {{"Host", own}, {"Sec-Fetch-Site", "cross-site"}, {"Sec-Fetch-Mode", "no-cors"}}));
  for (const char* site : {"same-origin", "same-site", "none"}) {
    EXPECT_TRUE(admits(guard, "GET", {{"Host", own}, {"Sec-Fetch-Site", site}})) << site;
  }
}

TEST(BrowserGuardTest, a_link_to_the_page_may_be_followed_and_a_frame_may_not_show_it) {
  const BrowserGuard guard({}, {});
  const auto visit = [&](const char* method, const char* destination) {
    return admits(guard, method,
                  {{"Host", "localhost"},
                   {"Sec-Fetch-Site", "cross-site"},
                   {"Sec-Fetch-Mode", "navigate"},
                   {"Sec-Fetch-Dest", destination}});
  };
  EXPECT_TRUE(visit("GET", "document"));
  EXPECT_FALSE(visit("POST", "document"));
  EXPECT_FALSE(visit("GET", "iframe"));
}

TEST(BrowserGuardTest, one_setting_opens_it) {
  const BrowserGuard guard({"*"}, {});
  EXPECT_TRUE(admits(guard, "POST", {{"Host", "evil.example"}, {"Origin", "https://evil.example"}}));
  EXPECT_TRUE(admits(guard, "POST", {{"Host", "localhost"}, {"Origin", "https://evil.example"}}));
}

}  // namespace
}  // namespace surfaced
