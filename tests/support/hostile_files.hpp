// SPDX-License-Identifier: GPL-3.0-or-later
// Claims about damaged and lying files, whatever their format.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/limited_child.hpp"
#include "support/results.hpp"

namespace surfaced::testing {

/// A file, the code it is refused with, and what the refusal says.
struct Refused {
  std::string what;
  std::string text;
  std::string code;
  std::string detail;
};

inline void expect_refused(const std::vector<Refused>& files) {
  for (const Refused& file : files) {
    const auto cloud = parse_text(file.text);
    EXPECT_EQ(code_of(cloud), file.code) << file.what << ": " << detail_of(cloud);
    EXPECT_THAT(detail_of(cloud), ::testing::HasSubstr(file.detail)) << file.what;
  }
}

/// Files of a megabyte, whatever is in them, are read or refused as clouds and as meshes within 2 seconds and 200 MB.
inline void expect_cheap(const std::vector<std::string>& files) {
  for (const std::string& text : files) {
    const ChildRun run = run_in_child(
        [&] { return (parse_text(text).ok() ? 1 : 0) + (decode_mesh(as_bytes(text), "mesh").ok() ? 1 : 0); });
    const std::string start = text.substr(0, 60);
    EXPECT_NE(run.result, -1) << start;
    EXPECT_LT(run.seconds, 2) << start;
    EXPECT_LT(run.peak_bytes, std::uint64_t{200} << 20) << start;
  }
}

}  // namespace surfaced::testing
