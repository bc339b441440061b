// SPDX-License-Identifier: GPL-3.0-or-later
#include "observability/metrics.hpp"

#include <gmock/gmock.h>

#include <thread>
#include <vector>

#include "execution/stage_clock.hpp"
#include "observability/log.hpp"

namespace surfaced {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(MetricsTest, requests_and_attempts_are_counted_by_their_labels) {
  Metrics metrics("9.9");
  metrics.request("GET", "/v1/jobs/{id}", 200, 0.02);
  metrics.request("GET", "/v1/jobs/{id}", 200, 0.02);
  metrics.attempt("poisson", "crashed", 2, 1 << 20);
  Gauges gauges;
  gauges.jobs_accepted = 7;
  gauges.ready = true;
  const std::string text = metrics.text(gauges);
  EXPECT_THAT(text, HasSubstr(R"(surfaced_http_requests_total{method="GET",route="/v1/jobs/{id}",status="200"} 2)"));
  EXPECT_THAT(text, HasSubstr(R"(surfaced_attempts_total{method="poisson",outcome="crashed"} 1)"));
  EXPECT_THAT(text, HasSubstr(R"(surfaced_jobs{status="accepted"} 7)"));
  EXPECT_THAT(text, HasSubstr("surfaced_ready 1"));
  EXPECT_THAT(text, HasSubstr(R"(surfaced_build_info{version="9.9"} 1)"));
}

TEST(MetricsTest, labels_that_clients_and_children_make_up_are_few) {
  Metrics metrics("1");
  for (int i = 0; i < 500; ++i) {
    metrics.stage("m", "stage" + std::to_string(i), 1);
    metrics.request("METHOD" + std::to_string(i), "", 405, 0.1);
  }
  metrics.stage("m", "quote\" {}", 1);
  const std::string text = metrics.text({});
  EXPECT_THAT(text, HasSubstr(R"(stage="other")"));
  EXPECT_THAT(text, Not(HasSubstr("stage499")));
  EXPECT_THAT(text, Not(HasSubstr("quote")));
  EXPECT_THAT(text, HasSubstr(R"({method="other",route="none",status="405"} 500)"));
}

TEST(MetricsTest, threads_count_together) {
  Metrics metrics("1");
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int k = 0; k < 200; ++k) {
        metrics.request("GET", "/", 200, 0.001);
        metrics.stage("m", "read", 0.1);
        if (k % 50 == 0) metrics.text({});
      }
    });
  }
  for (auto& each : threads) each.join();
  EXPECT_THAT(metrics.text({}), HasSubstr(R"(route="/",status="200"} 800)"));
}

TEST(StageClockTest, stages_follow_each_other_and_their_number_is_bounded) {
  StageClock clock;
  for (int i = 0; i < 100; ++i) {
    clock.enter("a" + std::to_string(i));
    clock.enter("a" + std::to_string(i));
  }
  clock.close();
  EXPECT_EQ(clock.stages().size(), 32U);
  EXPECT_EQ(clock.stages().front().first, "a0");
}

TEST(LogTest, a_line_is_json_with_its_fields_or_text) {
  set_up_log(LogFormat::json, LogLevel::info);
  ::testing::internal::CaptureStderr();
  log(LogLevel::info, "said \"so\"", {{"job", "j\xFF"}, {"seconds", 1.5}, {"detail", ""}});
  log(LogLevel::debug, "not worth it");
  const std::string line = ::testing::internal::GetCapturedStderr();
  const auto json = nlohmann::json::parse(line);
  EXPECT_EQ(json.at("message"), "said \"so\"");
  EXPECT_EQ(json.at("level"), "info");
  EXPECT_EQ(json.at("seconds"), 1.5);
  EXPECT_FALSE(json.contains("detail"));
  set_up_log(LogFormat::text, LogLevel::info);
  ::testing::internal::CaptureStderr();
  log(LogLevel::warning, "so", {{"job", "j"}});
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("Z warning so job=\"j\"\n"));
}

TEST(LogTest, the_trace_id_is_the_second_part_of_the_context) {
  EXPECT_EQ(trace_id_of("00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"), "0af7651916cd43dd8448eb211c80319c");
  EXPECT_EQ(trace_id_of(""), "");
}

}  // namespace
}  // namespace surfaced
