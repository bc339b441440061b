// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/base.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

namespace surfaced {
namespace {

TEST(ErrorCode, names_stand_in_the_list_of_error_codes) {
  ErrorCode code{};
  EXPECT_EQ(name_of(ErrorCode::too_few_points), "too_few_points");
  ASSERT_TRUE(error_code_named("collinear", code));
  EXPECT_EQ(code, ErrorCode::collinear);
  EXPECT_FALSE(error_code_named("no_such_code", code));
}

TEST(ErrorCode, exit_codes_are_those_of_the_contract) {
  EXPECT_EQ(exit_code_of(ErrorCode::invalid_usage), 2);
  EXPECT_EQ(exit_code_of(ErrorCode::truncated_input), 3);
  EXPECT_EQ(exit_code_of(ErrorCode::method_failed), 4);
  EXPECT_EQ(exit_code_of(ErrorCode::cancelled), 5);
}

TEST(Fault, what_was_given_is_echoed_to_a_bounded_length_between_two_characters) {
  const std::string name(1'000'000, 'n');
  const Error named =
      with_fault({ErrorCode::unknown_parameter, "no parameter '" + name + "'; there is x"}, {name, std::nullopt, "x"});
  const std::string cut = std::string(1000, 'n') + "...";
  EXPECT_EQ(named.detail, "no parameter '" + cut + "'; there is x");
  EXPECT_EQ(named.fault->field, cut);
  std::string accents = "a";
  while (accents.size() < 5000) accents += "\u00e9";
  const Error valued =
      with_fault({ErrorCode::invalid_parameter, "'x' is '" + accents + "'"}, {"x", accents, "a number"});
  EXPECT_EQ(*valued.fault->value, accents.substr(0, 999) + "...");
  EXPECT_EQ(valued.detail, "'x' is '" + accents.substr(0, 999) + "...'");
  const Error brief = with_fault({ErrorCode::invalid_parameter, "'x' is '7'"}, {"x", "7", "a word"});
  EXPECT_EQ(brief.detail, "'x' is '7'");
}

TEST(Result, holds_a_value_or_an_error) {
  const Result<int> value = 7;
  const Result<int> error = Error{ErrorCode::empty_input, "0 bytes"};
  ASSERT_TRUE(value);
  EXPECT_EQ(*value, 7);
  ASSERT_FALSE(error);
  EXPECT_EQ(error.error().code, ErrorCode::empty_input);
}

[[gnu::noinline]] Point3 rounded_to_float32(const Point3& p) {
  Point3 r;
  for (std::size_t axis = 0; axis < 3; ++axis) r[axis] = static_cast<double>(static_cast<float>(p[axis]));
  return r;
}

TEST(RoundingToFloat32, happens_in_every_coordinate) {
  for (const double x : rounded_to_float32({0.1, 0.1, 0.1})) EXPECT_EQ(x, 0x1.99999ap-4);
}

TEST(Index, is_invalid_until_set) {
  EXPECT_FALSE(VertexIndex().valid());
  EXPECT_TRUE(VertexIndex(0).valid());
  EXPECT_LT(VertexIndex(3), VertexIndex(4));
}

TEST(Context, progress_never_falls_and_sections_nest) {
  std::vector<double> seen;
  Context context(1, [&](double fraction, std::string_view) { seen.push_back(fraction); });
  context.section(0.2);
  context.enter("read", 1);
  context.report(0.5);
  context.section(0.8);
  context.enter("a", 0.5);
  context.report(1);
  context.report(0.1);
  context.enter("b", 1);
  context.report(0.5);
  ASSERT_TRUE(std::ranges::is_sorted(seen));
  EXPECT_DOUBLE_EQ(seen.front(), 0);
  EXPECT_NEAR(seen.back(), 0.65, 1e-12);
}

TEST(Context, stages_are_listed_in_order_of_entry_and_add_up) {
  Context context;
  context.enter("one", 0.5);
  context.enter("two", 1);
  context.enter("one", 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const std::vector<Stage> stages = context.finish();
  ASSERT_EQ(stages.size(), 2U);
  EXPECT_EQ(stages[0].name, "one");
  EXPECT_GE(stages[0].seconds, 0.005);
}

TEST(Context, tells_that_it_was_cancelled) {
  std::atomic<bool> cancel = false;
  const Context context(2, {}, &cancel);
  EXPECT_FALSE(context.cancelled());
  cancel = true;
  EXPECT_TRUE(context.cancelled());
}

}  // namespace
}  // namespace surfaced
