// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/conditional.hpp"

#include <gtest/gtest.h>

#include "platform/clock.hpp"

namespace surfaced::http {
namespace {

constexpr std::string_view kEtag = "\"abc\"";

Headers with(const std::string& name, const std::string& value) {
  Headers headers;
  headers.add(name, value);
  return headers;
}

std::string range_of(const Headers& headers, std::uint64_t size = 100) {
  const auto range = requested_range(headers, kEtag, size);
  if (!range) return std::string(name_of(range.error().code));
  if (!range->has_value()) return "whole";
  return std::to_string((*range)->offset) + "+" + std::to_string((*range)->length);
}

TEST(ConditionalTest, one_range_is_read_in_its_three_forms) {
  EXPECT_EQ(range_of(with("Range", "bytes=0-3")), "0+4");
  EXPECT_EQ(range_of(with("Range", "Bytes=90-")), "90+10");
  EXPECT_EQ(range_of(with("Range", "bytes=-5")), "95+5");
  EXPECT_EQ(range_of(with("Range", "bytes=-500")), "0+100");
  EXPECT_EQ(range_of(with("Range", "bytes=99-1000")), "99+1");
  EXPECT_EQ(range_of(with("Range", "bytes=0-18446744073709551615")), "0+100");
}

TEST(ConditionalTest, a_range_behind_the_end_cannot_be_served) {
  EXPECT_EQ(range_of(with("Range", "bytes=100-")), "range_not_satisfiable");
  EXPECT_EQ(range_of(with("Range", "bytes=-0")), "range_not_satisfiable");
  EXPECT_EQ(range_of(with("Range", "bytes=0-0"), 0), "range_not_satisfiable");
  EXPECT_EQ(range_of(with("Range", "bytes=-1"), 0), "range_not_satisfiable");
}

TEST(ConditionalTest, several_ranges_and_other_units_give_the_whole) {
  for (const char* value : {"bytes=0-1,2-3", "bytes=0-1, -3 ,7-", "lines=1-2", ""}) {
    EXPECT_EQ(range_of(with("Range", value)), "whole") << value;
  }
}

TEST(ConditionalTest, what_is_no_range_is_refused_with_the_value_and_what_is_allowed) {
  for (const char* value : {"bytes=", "bytes=-", "bytes=5-2", "bytes=a-b", "bytes=1", "bytes=99999999999999999999-",
                            "bytes=+1-2", "bytes=0-1,", "bytes=0-1,x"}) {
    const auto range = requested_range(with("Range", value), kEtag, 100);
    ASSERT_FALSE(range) << value;
    EXPECT_EQ(range.error().code, ErrorCode::range_not_satisfiable);
    EXPECT_EQ(range.error().fault->field, "Range");
    EXPECT_EQ(range.error().fault->value, value);
    EXPECT_NE(range.error().fault->allowed.find("100 bytes"), std::string::npos);
  }
}

TEST(ConditionalTest, if_range_asks_for_the_part_only_of_the_same_file) {
  Headers same = with("Range", "bytes=0-3");
  same.add("If-Range", std::string(kEtag));
  EXPECT_EQ(range_of(same), "0+4");
  Headers other = with("Range", "bytes=0-3");
  other.add("If-Range", "\"other\"");
  EXPECT_EQ(range_of(other), "whole");
}

TEST(ConditionalTest, if_none_match_knows_lists_weak_tags_and_the_star) {
  EXPECT_TRUE(not_modified(with("If-None-Match", "\"abc\""), kEtag));
  EXPECT_TRUE(not_modified(with("If-None-Match", "\"x\", W/\"abc\""), kEtag));
  EXPECT_TRUE(not_modified(with("If-None-Match", "*"), kEtag));
  EXPECT_FALSE(not_modified(with("If-None-Match", "\"ab\""), kEtag));
  EXPECT_FALSE(not_modified({}, kEtag));
}

TEST(ClockTest, a_time_has_an_offset_that_there_is) {
  const auto at_noon = parse_rfc3339("2026-11-24T12:00:00Z");
  ASSERT_TRUE(at_noon);
  EXPECT_EQ(parse_rfc3339("2026-11-24T13:30:00+01:30"), at_noon);
  EXPECT_EQ(parse_rfc3339("2026-11-23T12:01:00-23:59"), at_noon);
  for (const char* offset : {"+24:00", "+00:60", "-99:99", "+1:00", "+0100"}) {
    EXPECT_FALSE(parse_rfc3339(std::string("2026-11-24T12:00:00") + offset)) << offset;
  }
}

}  // namespace
}  // namespace surfaced::http
