// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/multipart.hpp"

#include <gmock/gmock.h>

#include <vector>

#include "platform/files.hpp"

namespace surfaced::http {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Seen {
  std::vector<std::string> parts;
  Status status = Done{};
};

/// Reads the body in pieces of this size.
Seen read(std::string_view body, std::size_t piece, std::string_view boundary = "B") {
  Seen seen;
  MultipartReader reader(boundary, {[&](const Part& part) {
                                      seen.parts.push_back((part.is_file ? "file " : "field ") + part.name + "=");
                                      return Status(Done{});
                                    },
                                    [&](std::span<const std::byte> bytes) {
                                      seen.parts.back().append(reinterpret_cast<const char*>(bytes.data()),
                                                               bytes.size());
                                      return Status(Done{});
                                    },
                                    [&] {
                                      seen.parts.back() += ";";
                                      return Status(Done{});
                                    }});
  for (std::size_t at = 0; at < body.size() && seen.status.ok(); at += piece) {
    seen.status = reader.feed(as_bytes(body.substr(at, piece)));
  }
  if (seen.status.ok()) seen.status = reader.finish();
  return seen;
}

constexpr std::string_view kForm =
    "--B\r\nContent-Disposition: form-data; name=\"method\"\r\n\r\npoisson\r\n"
    "--B \r\ncontent-disposition: form-data; name=cloud; filename=\"a;b.ply\"\r\nContent-Type: x/y\r\n\r\n"
    "ply\r\n--Bad\r\n\r\n--\r\n--B\r\nContent-Disposition: form-data; name=\"e\"\r\n\r\n\r\n--B--\r\nrest";

TEST(MultipartTest, parts_are_the_same_however_the_body_is_cut) {
  for (std::size_t piece = 1; piece < kForm.size(); ++piece) {
    // A boundary ends its line; "--Bad" would be a boundary with something behind it.
    std::string form(kForm);
    form.replace(form.find("--Bad"), 5, "-Bad");
    const Seen seen = read(form, piece);
    ASSERT_TRUE(seen.status.ok()) << piece << " " << seen.status.error().detail;
    EXPECT_THAT(seen.parts, ElementsAre("field method=poisson;", "file cloud=ply\r\n-Bad\r\n\r\n--;", "field e=;"));
  }
}

TEST(MultipartTest, a_body_that_breaks_the_rules_is_refused_with_the_reason) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"", "ends before"},
      {"--B\r\nContent-Disposition: form-data; name=a\r\n\r\nx", "ends before"},
      {std::string(9000, 'x'), "does not begin"},
      {std::string(kForm), "something behind"},
      {"--B\r\n\r\n\r\n--B--", "without Content-Disposition"},
      {"--B\r\nContent-Disposition: attachment; name=a\r\n\r\n--B--", "no form-data"},
      {"--B\r\nContent-Disposition: form-data\r\n\r\n--B--", "without a name"},
      {"--B\r\nnonsense\r\n\r\n--B--", "without a colon"},
      {"--B\r\nX: " + std::string(9000, 'x') + "\r\n\r\n--B--", "more than 8192 bytes"},
  };
  for (const auto& [body, why] : wrong) {
    for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, std::size_t{100'000}}) {
      const Seen seen = read(body, piece);
      ASSERT_FALSE(seen.status.ok()) << body.substr(0, 80);
      EXPECT_EQ(seen.status.error().code, ErrorCode::invalid_request);
      EXPECT_THAT(seen.status.error().detail, HasSubstr(why)) << body.substr(0, 80);
    }
  }
}

TEST(MultipartTest, the_number_of_parts_is_bounded) {
  std::string body;
  for (int i = 0; i < 65; ++i) body += "--B\r\nContent-Disposition: form-data; name=a\r\n\r\n\r\n";
  EXPECT_THAT(read(body + "--B--", 1000).status.error().detail, HasSubstr("more than 64 parts"));
}

TEST(MultipartTest, boundaries_are_those_of_rfc_2046) {
  EXPECT_EQ(multipart_boundary("multipart/form-data; charset=x; boundary=\"a b:c\"").value(), "a b:c");
  EXPECT_EQ(multipart_boundary("multipart/form-data;BOUNDARY=----WebKit7").value(), "----WebKit7");
  for (const char* wrong : {"multipart/form-data", "multipart/form-data; boundary=",
                            "multipart/form-data; boundary=\"a", "multipart/form-data; boundary=a\x01"}) {
    EXPECT_FALSE(multipart_boundary(wrong).ok()) << wrong;
  }
  EXPECT_FALSE(multipart_boundary("multipart/form-data; boundary=" + std::string(71, 'a')).ok());
}

}  // namespace
}  // namespace surfaced::http
