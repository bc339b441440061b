// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/request_head.hpp"

#include <gtest/gtest.h>

#include "http/chunk_guard.hpp"

namespace surfaced::http {
namespace {

RequestHead parsed(const std::string& text) {
  const auto head = parse_head(text);
  EXPECT_TRUE(head.ok()) << (head.ok() ? "" : head.error().detail);
  return head.ok() ? *head : RequestHead{};
}

bool refused(const std::string& text) {
  const auto head = parse_head(text);
  return !head.ok() && head.error().code == ErrorCode::invalid_request;
}

TEST(RequestHeadTest, takes_line_fields_and_length_apart) {
  const RequestHead head =
      parsed("POST /v1/jobs?a=1#x HTTP/1.1\r\nHost: h\r\nContent-Length:  12 \r\nX-A: b:c\r\n\r\n");
  EXPECT_EQ(head.method, "POST");
  EXPECT_EQ(head.path, "/v1/jobs");
  EXPECT_EQ(head.query, "a=1");
  EXPECT_EQ(head.headers.find("x-a"), "b:c");
  EXPECT_EQ(std::get<LengthBody>(head.framing).bytes, 12U);
  EXPECT_FALSE(head.close);
}

TEST(RequestHeadTest, knows_when_the_connection_ends_and_when_a_client_waits) {
  EXPECT_TRUE(parsed("GET / HTTP/1.0\r\n\r\n").close);
  EXPECT_TRUE(parsed("GET / HTTP/1.1\r\nHost: h\r\nConnection: CLOSE\r\n\r\n").close);
  EXPECT_TRUE(parsed("GET / HTTP/1.1\r\nHost: h\r\nConnection: keep-alive, close\r\n\r\n").close);
  EXPECT_TRUE(parsed("GET / HTTP/1.1\r\nHost: h\r\nConnection: TE\r\nConnection: x ,\tClose\r\n\r\n").close);
  EXPECT_FALSE(parsed("GET / HTTP/1.1\r\nHost: h\r\nConnection: keep-alive, closed\r\n\r\n").close);
  EXPECT_TRUE(parsed("POST / HTTP/1.1\r\nHost: h\r\nExpect: 100-Continue\r\n\r\n").expects_continue);
}

TEST(RequestHeadTest, refuses_what_two_readers_could_understand_differently) {
  const std::string line = "POST / HTTP/1.1\r\nHost: h\r\n";
  EXPECT_TRUE(refused(line + "Content-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n"));
  EXPECT_TRUE(refused(line + "Content-Length: 1\r\nContent-Length: 1\r\n\r\n"));
  EXPECT_TRUE(refused(line + "Content-Length: +1\r\n\r\n"));
  EXPECT_TRUE(refused(line + "Content-Length: 1, 1\r\n\r\n"));
  EXPECT_TRUE(refused(line + "Content-Length: 99999999999999999999\r\n\r\n"));
  EXPECT_TRUE(refused(line + "Content-Length:\r\n\r\n"));
  EXPECT_TRUE(refused(line + "Transfer-Encoding: gzip, chunked\r\n\r\n"));
  EXPECT_TRUE(refused(line + "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n\r\n"));
  EXPECT_TRUE(refused(line + "X: a\r\n folded\r\n\r\n"));
  EXPECT_TRUE(refused(line + "X : a\r\n\r\n"));
  EXPECT_TRUE(refused(line + "X: a\nY: b\r\n\r\n"));
  EXPECT_TRUE(refused(line + "X: a\rb\r\n\r\n"));
  EXPECT_TRUE(refused(line + "no colon\r\n\r\n"));
  EXPECT_TRUE(refused("POST / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"));
  EXPECT_TRUE(refused("GET / HTTP/1.1\r\n\r\n"));
  EXPECT_TRUE(refused("GET /a b HTTP/1.1\r\nHost: h\r\n\r\n"));
  EXPECT_TRUE(refused("GET / HTTP/2\r\nHost: h\r\n\r\n"));
  EXPECT_TRUE(refused("GET /\r\n\r\n"));
  EXPECT_TRUE(refused("\r\n\r\n"));
}

TEST(RequestHeadTest, takes_a_target_in_absolute_form_whose_host_counts) {
  const auto asked = [](const std::string& target) {
    return parsed("GET " + target + " HTTP/1.1\r\nHost: other\r\n\r\n");
  };
  const RequestHead head = asked("http://mesh.example:8080/v1/jobs?a=1&b#c");
  EXPECT_EQ(head.path, "/v1/jobs");
  EXPECT_EQ(head.query, "a=1&b");
  EXPECT_EQ(head.headers.find("Host"), "mesh.example:8080");
  EXPECT_EQ(head.headers.count("Host"), 1U);
  EXPECT_EQ(asked("HTTPS://h").path, "/");
  EXPECT_EQ(asked("http://h?a").query, "a");
  EXPECT_EQ(asked("http://h/a/http://b").path, "/a/http://b");
  EXPECT_EQ(asked("/http://b/").path, "/http://b/");
  for (const char* target : {"http:///", "http://", "http://user@h/", "http://h:x/", "ftp://h/", "http:/h/", "h:80",
                             "*", "http://a b/", "http://h\\@evil/"}) {
    EXPECT_TRUE(refused(std::string("GET ") + target + " HTTP/1.1\r\nHost: h\r\n\r\n")) << target;
  }
}

TEST(RequestHeadTest, takes_hosts_and_refuses_what_is_none) {
  for (const char* host :
       {"h", "mesh.example", "a_b-c.d", "127.0.0.1:80", "[::1]", "[2001:db8::1]:8080", "h:", "h:65535"}) {
    EXPECT_TRUE(parse_head(std::string("GET / HTTP/1.1\r\nHost: ") + host + "\r\n\r\n").ok()) << host;
  }
  for (const char* host :
       {"",     "a b", "a/b",  "a@b",    "a,b", "a?b",         "a#b", "<a>",      "h:80:81", "h:65536", "h:-1",
        "h:8o", ":80", "[::1", "[::1]x", "[h]", "[127.0.0.1]", "::1", "http://h", "h\\",     "\xC3\xA4"}) {
    EXPECT_TRUE(refused(std::string("GET / HTTP/1.1\r\nHost: ") + host + "\r\n\r\n")) << host;
    EXPECT_TRUE(refused(std::string("GET / HTTP/1.0\r\nHost: ") + host + "\r\n\r\n")) << host;
  }
  EXPECT_TRUE(refused("GET / HTTP/1.1\r\nHost: " + std::string(256, 'h') + "\r\n\r\n"));
}

TEST(RequestHeadTest, counts_header_fields) {
  std::string text = "GET / HTTP/1.1\r\nHost: h\r\n";
  for (int i = 0; i < 100; ++i) text += "X: y\r\n";
  EXPECT_EQ(parse_head(text + "\r\n").error().code, ErrorCode::headers_too_large);
}

TEST(QueryTest, is_decoded_in_its_order) {
  const Query query = parse_query("b=1&a=x%20y+z&b=&c&&%C3%A4=%26").value();
  ASSERT_EQ(query.size(), 5U);
  EXPECT_EQ(query[1].second, "x y z");
  EXPECT_EQ(query[2].first, "b");
  EXPECT_EQ(query[3].second, "");
  EXPECT_EQ(query[4].first, "\xC3\xA4");
  EXPECT_EQ(query[4].second, "&");
}

TEST(QueryTest, has_at_most_200_names) {
  std::string text;
  for (int i = 0; i < 200; ++i) text += "a&&";
  EXPECT_TRUE(parse_query(text).ok());
  EXPECT_EQ(parse_query(text + "b").error().code, ErrorCode::invalid_request);
}

TEST(QueryTest, broken_escapes_nul_and_bytes_that_are_no_utf8_are_refused) {
  for (const char* text :
       {"a=%", "a=%4", "a=%zz", "a=%00", "a=%FF", "a=%C0%80", "a=%ED%A0%80", "a=%F5%80%80%80", "a=%C3"}) {
    EXPECT_FALSE(parse_query(text).ok()) << text;
  }
}

bool accepts(std::string_view bytes) {
  ChunkGuard whole;
  const bool at_once = whole.accept(bytes) && whole.complete();
  ChunkGuard pieces;
  bool in_pieces = true;
  for (const char byte : bytes) in_pieces = in_pieces && pieces.accept({&byte, 1});
  EXPECT_EQ(at_once, in_pieces && pieces.complete()) << bytes;
  return at_once;
}

TEST(ChunkGuardTest, takes_chunks_as_the_standard_writes_them) {
  EXPECT_TRUE(accepts("0\r\n\r\n"));
  EXPECT_TRUE(accepts("3\r\nabc\r\n00a\r\n0123456789\r\n000\r\n\r\n"));
  EXPECT_TRUE(accepts("3;name=value\r\nabc\r\n0;x\r\n\r\n"));
}

TEST(ChunkGuardTest, refuses_everything_else) {
  for (const char* bytes :
       {"", "3\r\nabc\r\n", "3\r\nabcd\r\n0\r\n\r\n", "+3\r\nabc\r\n0\r\n\r\n", "0x3\r\nabc\r\n0\r\n\r\n", "-1\r\n",
        " 3\r\nabc\r\n0\r\n\r\n", "3 \r\nabc\r\n0\r\n\r\n", "3\nabc\n0\n\n", "\r\n", "fffffffffffffffff\r\n",
        "3\r\nabc0\r\n\r\n", "0\r\nTrailer: x\r\n\r\n", "0\r\n\r\nmore", ";\r\n"}) {
    EXPECT_FALSE(accepts(bytes)) << bytes;
  }
  EXPECT_FALSE(accepts("3;" + std::string(1000, 'x') + "\r\nabc\r\n0\r\n\r\n"));
}

}  // namespace
}  // namespace surfaced::http
