// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/nearest.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace surfaced {
namespace {

const std::vector<std::string> kNames{"minimum-boundary", "local-delaunay", "poisson", "job-memory", "ttl", "x"};

TEST(NearestName, is_what_was_meant) {
  EXPECT_EQ(nearest_name("minimum_boundary", kNames), "minimum-boundary");
  EXPECT_EQ(nearest_name("Poisson", kNames), "poisson");
  EXPECT_EQ(nearest_name("posison", kNames), "poisson") << "neighbours swapped are one edit";
  EXPECT_EQ(nearest_name("lcal-delauny", kNames), "local-delaunay");
  EXPECT_EQ(nearest_name("memory", kNames), "job-memory");
  EXPECT_EQ(nearest_name("minimum", kNames), "minimum-boundary");
  EXPECT_EQ(nearest_name("tll", kNames), "ttl");
}

TEST(NearestName, is_empty_where_nothing_is_near) {
  for (const char* written : {"", "marching-cubes", "zz", "y", "mem"})
    EXPECT_EQ(nearest_name(written, kNames), "") << written;
  EXPECT_EQ(nearest_name(std::string(1'000'000, 'p'), kNames), "") << "and costs nothing";
  EXPECT_EQ(nearest_name("poisson", {}), "");
  EXPECT_EQ(did_you_mean("quite else", kNames), "");
  EXPECT_EQ(did_you_mean("poison", kNames), "Did you mean 'poisson'?");
}

TEST(DidYouMean, reads_the_words_that_an_error_allows) {
  const auto asks = [](const char* field, std::optional<std::string> value, const char* allowed) {
    return did_you_mean(with_fault({ErrorCode::invalid_parameter, "wrong"}, {field, std::move(value), allowed}));
  };
  EXPECT_EQ(asks("variant", "\"bset\"", "one of \"best\", \"fast\""), "Did you mean 'best'?");
  EXPECT_EQ(asks("log-format", "jsn", "text|json"), "Did you mean 'json'?");
  EXPECT_EQ(asks("quantization", "\"nune\"", "\"none\" or an integer >= 8"), "Did you mean 'none'?");
  EXPECT_EQ(asks("varant", std::nullopt, "one of variant, lids"), "Did you mean 'variant'?") << "the name itself";
  EXPECT_EQ(asks("ttl", "1 x", "1 s to 365 d"), "");
  EXPECT_EQ(asks("beta", "ones", "one of them"), "") << "prose is no list";
  EXPECT_EQ(did_you_mean(Error{ErrorCode::cancelled, "no fault"}), "");
}

}  // namespace
}  // namespace surfaced
