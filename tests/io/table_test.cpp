// SPDX-License-Identifier: GPL-3.0-or-later
// Tables of text: what is guessed, by the table that the viewer's tests share, and how they are read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "io/io.hpp"
#include "support/results.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;
using Json = nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Points = std::vector<Point3>;

Json shared_cases() {
  std::ifstream file(SURFACED_TABLES);
  return Json::parse(file);
}

Separator separator_named(const std::string& name) {
  for (const auto& [word, separator] : {std::pair{"blank", Separator::blank}, {"comma", Separator::comma}}) {
    if (name == word) return separator;
  }
  return Separator::guessed;
}

ReadOptions options_of(const Json& entry) {
  const Json given = entry.value("options", Json::object());
  ReadOptions options;
  options.table.columns = given.value("columns", "");
  options.table.separator = separator_named(given.value("separator", ""));
  options.table.decimal = given.value("decimal", "") == "comma" ? Decimal::comma : Decimal::guessed;
  options.table.skip = given.value("skip", 0U);
  return options;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
  return text;
}

TEST(Table, is_guessed_as_the_table_of_cases_that_the_viewer_shares_says) {
  const Json cases = shared_cases();
  ASSERT_GT(cases.size(), 40U);
  for (const Json& entry : cases) {
    const std::string name = entry.at("name");
    const auto cloud =
        parse_cloud(as_bytes(entry.at("text").get_ref<const std::string&>()), "table", options_of(entry));
    if (entry.contains("refused")) {
      EXPECT_EQ(code_of(cloud), entry.at("refused").get<std::string>()) << name << ": " << detail_of(cloud);
      continue;
    }
    ASSERT_TRUE(cloud.ok()) << name << ": " << detail_of(cloud);
    ASSERT_TRUE(cloud->source.table.has_value()) << name;
    const TableFacts& facts = *cloud->source.table;
    EXPECT_EQ(joined(facts.columns), entry.at("columns").get<std::string>()) << name;
    EXPECT_EQ(facts.separator, entry.at("separator").get<std::string>()) << name;
    EXPECT_EQ(facts.decimal, entry.at("decimal").get<std::string>()) << name;
    if (entry.contains("guessed")) {
      EXPECT_EQ(facts.guessed, entry.at("guessed").get<bool>()) << name;
    }
    // What was guessed is said, with the way to say it oneself.
    const std::string warnings = joined(cloud->warnings);
    if (facts.guessed) {
      EXPECT_THAT(warnings, HasSubstr("columns=" + joined(facts.columns))) << name;
    }
  }
}

/// The way out that a warning names gives the same cloud, without a guess.
TEST(Table, read_as_its_warning_says_gives_the_same_points_without_a_warning_of_a_guess) {
  for (const Json& entry : shared_cases()) {
    if (entry.contains("refused")) continue;
    const std::string& text = entry.at("text").get_ref<const std::string&>();
    ReadOptions options = options_of(entry);
    const auto guessed = parse_cloud(as_bytes(text), "table", options);
    options.table.columns = entry.at("columns").get<std::string>();
    if (entry.at("decimal") == "comma") options.table.decimal = Decimal::comma;
    const auto told = parse_cloud(as_bytes(text), "table", options);
    ASSERT_TRUE(told.ok()) << entry.at("name") << ": " << detail_of(told);
    EXPECT_EQ(told->size(), guessed->size()) << entry.at("name");
    EXPECT_EQ(told->colors, guessed->colors) << entry.at("name");
    EXPECT_THAT(joined(told->warnings), Not(HasSubstr("guessed"))) << entry.at("name");
  }
}

TEST(Table, values_behind_the_sample_may_undo_what_was_guessed_of_colours) {
  std::string text;
  for (int i = 0; i < 20000; ++i) text += "1.5 2.5 " + std::to_string(i) + " 100 90 80\n";
  EXPECT_EQ(parse_text(text)->colors.size(), 20000U);
  const auto cloud = parse_text(text + "1 2 3 300 1 2\n");
  ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
  EXPECT_TRUE(cloud->colors.empty());
  EXPECT_THAT(joined(cloud->warnings), HasSubstr("columns 4 to 6 ignored"));
}

TEST(Table, a_value_that_stands_for_no_measurement_is_nan) {
  const auto cloud = parse_text("x,y,z\n1,2,3\nNA,null,-\n4,,6\n");
  ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
  ASSERT_EQ(cloud->size(), 3U);
  EXPECT_TRUE(std::isnan(cloud->positions[1][0]) && std::isnan(cloud->positions[2][1]));
}

TEST(Table, an_empty_row_is_a_point_without_a_measurement_however_the_values_are_separated) {
  for (const char* text : {"x\ty\tz\n1\t2\t3\n\t\t\n4\t5\t6\n", "1,2,3,9\n,,,\n4,5,6,9\n", "1,2,3,9\n,,\n4,5,6,9\n",
                           "x;y;z;a;b\n1;2;3;9;9\n;;;;\n4;5;6;9;9\n", ",,\n1,2,3\n4,5,6\n",
                           "\"1\",\"2\",\"3\"\n\"\",\"\",\"\"\n4,5,6\n"}) {
    const auto cloud = parse_text(text);
    ASSERT_TRUE(cloud.ok()) << text << detail_of(cloud);
    EXPECT_EQ(cloud->size(), 3U) << text;
    EXPECT_EQ(std::ranges::count_if(cloud->positions, [](const Point3& p) { return std::isnan(p[0]); }), 1) << text;
  }
  // A line of blanks is none.
  EXPECT_EQ(parse_text("1 2 3\n \t\t\n4 5 6\n")->size(), 2U);
}

TEST(Table, text_that_is_none_is_called_text_and_shown) {
  const auto prose = parse_text("Dear Sir or Madam,\nyour letter of 29 5 2007, has arrived.\nYours,\nI\n");
  EXPECT_EQ(code_of(prose), "unknown_format");
  EXPECT_THAT(detail_of(prose), HasSubstr("is text, but no table of points"));
  EXPECT_THAT(detail_of(prose), HasSubstr("begins with 'Dear Sir or Madam,'"));
}

TEST(Table, of_utf_16_in_either_order_with_or_without_its_mark_is_read) {
  const std::string text = "x,y,z\r\n0.5,1,2\r\n3,4,5\r\n";
  for (const bool big : {false, true}) {
    for (const bool marked : {false, true}) {
      std::string wide = !marked ? "" : big ? "\xfe\xff" : "\xff\xfe";
      for (const char c : text) (wide += big ? '\0' : c) += big ? c : '\0';
      const auto cloud = parse_text(wide);
      ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
      EXPECT_EQ(cloud->positions, (Points{{0.5, 1, 2}, {3, 4, 5}}));
    }
  }
}

TEST(Table, rows_may_lack_what_is_not_read_but_not_what_is) {
  EXPECT_EQ(parse_text("1,1.5,2,3,tree\n2,4,5,6\n3,7,8,9,kerb,old\n")->size(), 3U);
  EXPECT_EQ(code_of(parse_text("x,y,z,code\n1,2,3,a\n4,5\n")), "malformed_input");
}

TEST(Table, refusals_name_what_was_found_and_a_way_out) {
  const auto names = parse_text("a,b,c\n1,2,3\n4,5,6\n");
  EXPECT_THAT(detail_of(names), HasSubstr("no columns x, y, z; found: 'a', 'b', 'c'; columns=x,y,z"));
  EXPECT_THAT(detail_of(parse_text("lon,lat,h\n11.5,48.1,500\n")), HasSubstr("columns=x,y,z"));
  EXPECT_THAT(detail_of(parse_text("0,01,0,02,0,03\n0,04,0,05,0,06\n")), HasSubstr("decimal commas"));
}

TEST(Table, more_points_than_a_pts_counts_are_read_with_a_warning_and_fewer_only_if_that_is_wanted) {
  const auto more = parse_text("1\n1 2 3\n4 5 6\n");
  ASSERT_TRUE(more.ok()) << detail_of(more);
  EXPECT_EQ(more->size(), 2U);
  EXPECT_THAT(more->warnings, ElementsAre(HasSubstr("1 points more than the file's counts declare")));
  const std::string few = "3\n10 20 30\n40 50 60\n\n\n\n\n\n\n";
  EXPECT_THAT(detail_of(parse_text(few)), HasSubstr("truncated=take"));
  ReadOptions options;
  options.take_truncated = true;
  EXPECT_EQ(parse_cloud(as_bytes(few), "few.pts", options)->size(), 2U);
}

}  // namespace
}  // namespace surfaced
