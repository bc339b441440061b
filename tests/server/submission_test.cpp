#include "api/submission.hpp"

#include <gmock/gmock.h>

namespace surfaced::api {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::chrono::seconds kTtl{3600};

ErrorCode code_of(const http::Query& query, Door door = Door::jobs) {
  const auto submission = read_submission(query, door, kTtl);
  EXPECT_FALSE(submission.ok());
  return submission.ok() ? ErrorCode::internal_error : submission.error().code;
}

TEST(SubmissionTest, defaults_stand_for_what_is_not_said) {
  const Submission submission = read_submission({}, Door::jobs, kTtl).value();
  EXPECT_FALSE(submission.method.empty());
  EXPECT_THAT(submission.outputs, ElementsAre("mesh.glb", "report.json", "log.txt"));
  EXPECT_EQ(submission.ttl, kTtl);
  EXPECT_EQ(submission.parameters.at("up"), "y");
}

TEST(SubmissionTest, every_name_that_is_not_reserved_is_a_parameter_of_the_method) {
  const Submission submission =
      read_submission({{"method", "advancing-front"}, {"beta", "0.5"}, {"up", "z"}}, Door::jobs, kTtl).value();
  EXPECT_EQ(submission.parameters.at("beta"), 0.5);
  EXPECT_EQ(submission.parameters.at("up"), "z");
  EXPECT_EQ(code_of({{"method", "advancing-front"}, {"gamma", "1"}}), ErrorCode::unknown_parameter);
  EXPECT_EQ(code_of({{"method", "advancing-front"}, {"beta", "99"}}), ErrorCode::invalid_parameter);
  EXPECT_EQ(code_of({{"method", "advancing-front"}, {"beta", "0.5"}, {"beta", "0.6"}}), ErrorCode::invalid_parameter);
}

TEST(SubmissionTest, wrong_methods_and_outputs_have_their_codes) {
  EXPECT_EQ(code_of({{"method", "magic"}}), ErrorCode::unknown_method);
  EXPECT_EQ(code_of({{"method", "magic"}, {"method", "magic"}}), ErrorCode::invalid_parameter);
  EXPECT_EQ(code_of({{"outputs", "mesh.xyz"}}), ErrorCode::unknown_output);
  EXPECT_EQ(code_of({{"outputs", "mesh.glb,mesh.ply"}}), ErrorCode::unknown_output);
  EXPECT_EQ(code_of({{"method", "advancing-front"}, {"outputs", "cloud.ply"}}), ErrorCode::unknown_output);
  EXPECT_EQ(code_of({{"output", "exe"}}, Door::reconstruct), ErrorCode::unknown_output);
}

TEST(SubmissionTest, each_door_takes_its_own_names_and_ignores_none) {
  EXPECT_EQ(code_of({{"output", "glb"}}), ErrorCode::unknown_parameter);
  EXPECT_EQ(code_of({{"outputs", "mesh.glb"}}, Door::reconstruct), ErrorCode::unknown_parameter);
  EXPECT_EQ(code_of({{"webhook", "https://example.org"}}), ErrorCode::unknown_parameter);
  EXPECT_THAT(read_submission({{"output", "ply"}}, Door::reconstruct, kTtl).value().outputs,
              ElementsAre("mesh.ply", "report.json", "log.txt"));
  EXPECT_THAT(read_submission({{"method", "intrinsic-delaunay"}, {"outputs", "cloud.ply,mesh.ply"}}, Door::jobs, kTtl)
                  .value()
                  .outputs,
              ElementsAre("mesh.ply", "cloud.ply", "report.json", "log.txt"));
  EXPECT_THAT(read_submission({{"outputs", "report.json,mesh.drc"}}, Door::jobs, kTtl).value().outputs,
              ElementsAre("mesh.drc", "report.json", "log.txt"));
}

TEST(SubmissionTest, the_time_to_live_has_bounds_that_the_error_names) {
  EXPECT_EQ(read_submission({{"ttl_seconds", "60"}}, Door::jobs, kTtl).value().ttl, std::chrono::seconds(60));
  for (const char* value : {"59", "2592001", "1e9", "-1", "x", "nan", " 60", "60 "}) {
    const auto submission = read_submission({{"ttl_seconds", value}}, Door::jobs, kTtl);
    ASSERT_FALSE(submission.ok()) << value;
    EXPECT_THAT(submission.error().detail, HasSubstr("from 60.0 to 2592000.0"));
  }
}

}  // namespace
}  // namespace surfaced::api
