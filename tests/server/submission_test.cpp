// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/submission.hpp"

#include <gmock/gmock.h>

namespace surfaced::api {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::chrono::seconds kTtl{3600};
constexpr SubmissionRules kRules{kTtl, false};
constexpr SubmissionRules kWithWebhooks{kTtl, true};

ErrorCode code_of(const http::Query& query, Endpoint endpoint = Endpoint::jobs) {
  const auto submission = read_submission(query, endpoint, kRules);
  EXPECT_FALSE(submission.ok());
  return submission.ok() ? ErrorCode::internal_error : submission.error().code;
}

TEST(SubmissionTest, defaults_stand_for_what_is_not_said) {
  const Submission submission = read_submission({}, Endpoint::jobs, kRules).value();
  EXPECT_FALSE(submission.method.empty());
  EXPECT_THAT(submission.outputs, ElementsAre("mesh.glb", "report.json", "log.txt"));
  EXPECT_EQ(submission.ttl, kTtl);
  EXPECT_EQ(submission.parameters.at("up"), "y");
}

TEST(SubmissionTest, every_name_that_is_not_reserved_is_a_parameter_of_the_method) {
  const Submission submission =
      read_submission({{"method", "advancing-front"}, {"beta", "0.5"}, {"up", "z"}}, Endpoint::jobs, kRules).value();
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
  EXPECT_EQ(code_of({{"method", "advancing-front"}, {"outputs", "cloud.ply"}}), ErrorCode::unknown_output);
  EXPECT_EQ(code_of({{"output", "exe"}}, Endpoint::reconstruct), ErrorCode::unknown_output);
}

TEST(SubmissionTest, each_door_takes_its_own_names_and_ignores_none) {
  EXPECT_EQ(code_of({{"output", "glb"}}), ErrorCode::unknown_parameter);
  EXPECT_EQ(code_of({{"outputs", "mesh.glb"}}, Endpoint::reconstruct), ErrorCode::unknown_parameter);
  EXPECT_EQ(code_of({{"wait", "3"}}), ErrorCode::unknown_parameter);
  EXPECT_EQ(code_of({{"cloud_id", "00"}}), ErrorCode::conflicting_input);
  EXPECT_THAT(read_submission({{"output", "ply"}}, Endpoint::reconstruct, kRules).value().outputs,
              ElementsAre("mesh.ply", "report.json", "log.txt"));
  EXPECT_THAT(
      read_submission({{"method", "intrinsic-delaunay"}, {"outputs", "cloud.ply,mesh.ply"}}, Endpoint::jobs, kRules)
          .value()
          .outputs,
      ElementsAre("mesh.ply", "cloud.ply", "report.json", "log.txt"));
  EXPECT_THAT(read_submission({{"outputs", "report.json,mesh.drc"}}, Endpoint::jobs, kRules).value().outputs,
              ElementsAre("mesh.drc", "report.json", "log.txt"));
}

TEST(SubmissionTest, the_time_to_live_has_bounds_that_the_error_names) {
  EXPECT_EQ(read_submission({{"ttl_seconds", "60"}}, Endpoint::jobs, kRules).value().ttl, std::chrono::seconds(60));
  for (const char* value : {"59", "2592001", "1e9", "-1", "x", "nan", " 60", "60 "}) {
    const auto submission = read_submission({{"ttl_seconds", value}}, Endpoint::jobs, kRules);
    ASSERT_FALSE(submission.ok()) << value;
    EXPECT_THAT(submission.error().detail, HasSubstr("from 60 to 2592000"));
  }
}

TEST(SubmissionTest, several_meshes_may_be_asked_for_each_counts_once) {
  EXPECT_THAT(read_submission({{"outputs", "mesh.ply,mesh.glb,mesh.ply"}}, Endpoint::jobs, kRules).value().outputs,
              ElementsAre("mesh.ply", "mesh.glb", "report.json", "log.txt"));
}

TEST(SubmissionTest, labels_are_sorted_and_held_to_their_rules) {
  EXPECT_THAT(read_submission({{"labels", "b,a,b"}}, Endpoint::jobs, kRules).value().labels, ElementsAre("a", "b"));
  for (const std::string& wrong : {std::string("a b"), std::string(65, 'x'), std::string("\xc3\xa4")}) {
    EXPECT_EQ(code_of({{"labels", wrong}}), ErrorCode::invalid_parameter) << wrong;
  }
  std::string many;
  for (int i = 0; i < 17; ++i) many += "l" + std::to_string(i) + ",";
  EXPECT_EQ(code_of({{"labels", many}}), ErrorCode::invalid_parameter);
}

TEST(SubmissionTest, a_webhook_is_an_https_url_and_only_where_the_server_sends_them) {
  const http::Query asked{{"webhook", "https://example.org/hook"}};
  EXPECT_EQ(code_of(asked), ErrorCode::invalid_parameter);
  EXPECT_EQ(read_submission(asked, Endpoint::jobs, kWithWebhooks).value().webhook, "https://example.org/hook");
  EXPECT_EQ(read_submission({{"webhook", "http://example.org"}}, Endpoint::jobs, kWithWebhooks).error().code,
            ErrorCode::invalid_parameter);
}

TEST(SubmissionTest, json_says_the_same_and_names_the_field_that_is_wrong) {
  using Json = nlohmann::ordered_json;
  const Json body{{"cloud_id", "abc"},       {"method", "advancing-front"}, {"parameters", {{"beta", 0.5}}},
                  {"outputs", {"mesh.drc"}}, {"ttl_seconds", 60},           {"labels", {"x"}}};
  const Submission submission = read_submission(body, kRules).value();
  EXPECT_EQ(submission.cloud_id, "abc");
  EXPECT_EQ(submission.parameters.at("beta"), 0.5);
  EXPECT_EQ(submission.ttl, std::chrono::seconds(60));
  EXPECT_THAT(submission.outputs, ElementsAre("mesh.drc", "report.json", "log.txt"));
  const std::vector<std::pair<Json, ErrorCode>> wrong{
      {Json::array(), ErrorCode::invalid_request},
      {{{"colour", 1}}, ErrorCode::invalid_request},
      {{{"method", 1}}, ErrorCode::invalid_request},
      {{{"outputs", "mesh.glb"}}, ErrorCode::invalid_request},
      {{{"outputs", {1}}}, ErrorCode::invalid_request},
      {{{"parameters", 3}}, ErrorCode::invalid_request},
      {{{"parameters", {{"gamma", 1}}}}, ErrorCode::unknown_parameter},
      {{{"ttl_seconds", 59}}, ErrorCode::invalid_parameter},
      {{{"ttl_seconds", "60"}}, ErrorCode::invalid_parameter},
      {{{"labels", {"a b"}}}, ErrorCode::invalid_parameter},
  };
  for (const auto& [json, code] : wrong) {
    const auto refused = read_submission(json, kRules);
    ASSERT_FALSE(refused.ok()) << json;
    EXPECT_EQ(refused.error().code, code) << json << refused.error().detail;
  }
}

}  // namespace
}  // namespace surfaced::api
