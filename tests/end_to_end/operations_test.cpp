// SPDX-License-Identifier: GPL-3.0-or-later
// What an operator does: configure, watch, stop, back up, restore.
#include <gmock/gmock.h>

#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "support/service_client.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;
using testing::Answer;
using ::testing::AnyOf;
using testing::call;
using ::testing::HasSubstr;

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class OperationsTest : public ::testing::Test {
 protected:
  std::filesystem::path path(const char* name) const { return directory_.path() / name; }
  /// Runs the command with its output in the file `out` and its problems in `err`; the exit code.
  int run(const std::string& arguments) const {
    return run_shell("umask 077; " + environment_ + " " + SURFACED_BINARY + " " + arguments);
  }
  int run_shell(const std::string& command) const {
    const std::string all = command + " > " + path("out").string() + " 2> " + path("err").string();
    // NOLINTNEXTLINE(concurrency-mt-unsafe): the test has one thread
    return WEXITSTATUS(std::system(all.c_str()));
  }
  static std::string submit(std::uint16_t port, const std::string& cloud, const testing::Fields& fields = {}) {
    const Answer answer = call(port, "POST", "/v1/jobs?method=advancing-front", cloud, fields);
    EXPECT_EQ(answer.status, 201) << answer.body;
    return Json::parse(answer.body).at("id");
  }

  testing::TemporaryDirectory directory_;
  std::string environment_;
  const std::string cloud_ = testing::binary_ply(testing::sphere_points(500));
};

TEST_F(OperationsTest, check_config_shows_every_setting_and_where_it_comes_from) {
  std::ofstream(path("c.json")) << R"({"queue-limit": 7})";
  environment_ = "SURFACED_DATA=" + path("data").string() + " SURFACED_LEASE=60";
  EXPECT_EQ(run("check-config " + path("c.json").string()), 0) << text_of(path("err"));
  const std::string out = text_of(path("out"));
  EXPECT_THAT(out, HasSubstr("queue-limit = 7  [file]"));
  EXPECT_THAT(out, HasSubstr("lease = 1 min  [SURFACED_LEASE]"));
  EXPECT_THAT(out, HasSubstr("listen = 127.0.0.1:8080  [default]"));
  EXPECT_EQ(run("check-config --json"), 0);
  EXPECT_GT(Json::parse(text_of(path("out"))).at("settings").size(), 20U);
  EXPECT_FALSE(std::filesystem::exists(path("data"))) << "looking changes nothing";
}

TEST_F(OperationsTest, check_config_and_serve_refuse_what_is_wrong_with_exit_code_2) {
  std::ofstream(path("c.json")) << R"({"queue-limit": "many"})";
  for (const char* command : {"check-config --config ", "serve --config "}) {
    EXPECT_EQ(run(command + path("c.json").string()), 2);
    const Json problem = Json::parse(text_of(path("err")));
    EXPECT_EQ(problem.at("code"), "invalid_usage");
    EXPECT_THAT(problem.at("detail").get<std::string>(), HasSubstr("queue-limit is 'many'; allowed is 1 to 1000000"));
    EXPECT_THAT(problem.at("detail").get<std::string>(), HasSubstr("data is not set"));
  }
}

TEST_F(OperationsTest, what_stands_in_the_way_of_a_start_is_said_with_what_to_do_about_it) {
  const auto refused = [&](const std::string& arguments) {
    EXPECT_EQ(run("serve " + arguments), 2) << text_of(path("err"));
    const std::string said = text_of(path("err"));  // the log, then the problem
    return Json::parse(said.substr(said.find("{\"code\""))).at("detail").get<std::string>();
  };
  std::ofstream(path("file")) << "no folder";
  EXPECT_THAT(refused("--data " + path("file").string() + "/data"),
              HasSubstr("no folder that this user can write: give another"));
  testing::ServerProcess running(path("data"));
  const std::string port = std::to_string(running.port());
  const std::string data = "--data " + path("other").string();
  EXPECT_THAT(refused(data + " --listen 127.0.0.1:" + port),
              HasSubstr("stop what listens there, or give another port"));
  EXPECT_THAT(refused(data + " --listen 192.0.2.1:80 --allow-anonymous yes"),
              HasSubstr("this machine has no such address"));
  EXPECT_THAT(refused(data + " --listen 0.0.0.0:0"), HasSubstr("give --keys FILE"));
  environment_ = "SURFACED_WORKERS=some";
  EXPECT_THAT(refused(data), HasSubstr("workers is 'some'; allowed is 0 to 1024 (from SURFACED_WORKERS)"));
}

TEST_F(OperationsTest, health_asks_the_server_that_listens_there) {
  testing::ServerProcess running(path("data"));
  environment_ = "SURFACED_LISTEN=0.0.0.0:" + std::to_string(running.port());
  EXPECT_EQ(run("health"), 0) << text_of(path("err"));
  EXPECT_THAT(text_of(path("out")), HasSubstr("is ready"));
  running.end(SIGKILL);
  EXPECT_EQ(run("health"), 5);
  const Json problem = Json::parse(text_of(path("err")));
  EXPECT_EQ(problem.at("code"), "not_ready");
  EXPECT_THAT(problem.at("detail").get<std::string>(), HasSubstr("no answer from http://127.0.0.1:"));
}

TEST_F(OperationsTest, a_public_address_without_keys_is_warned_of_in_the_log) {
  testing::ServerProcess server(path("data"), {"--allow-anonymous", "yes"}, path("log"), "0.0.0.0:0");
  EXPECT_EQ(server.end(SIGTERM), 0);
  EXPECT_THAT(text_of(path("log")), HasSubstr("surfaced keys add FILE"));
}

TEST_F(OperationsTest, a_server_that_is_told_to_stop_is_unready_at_once_and_answers_until_its_jobs_have_ended) {
  testing::ServerProcess server(path("data"), {"--drain-time", "600", "--workers", "1"});
  const std::string running = testing::start_endless_job(server, testing::random_points(20'000, 1));
  const std::string waiting = submit(server.port(), cloud_);
  ::kill(server.pid(), SIGTERM);
  EXPECT_TRUE(testing::eventually([&] { return call(server.port(), "GET", "/readyz").status == 503; }));
  EXPECT_EQ(call(server.port(), "GET", "/healthz").status, 200);
  const Answer refused = call(server.port(), "POST", "/v1/jobs?method=advancing-front", cloud_);
  EXPECT_EQ(refused.status, 503);
  EXPECT_THAT(refused.body, HasSubstr("the server is stopping"));
  for (const pid_t child : server.children()) ::kill(-child, SIGCONT);
  // A long poll is answered with the result, or at the latest when the server ends.
  EXPECT_EQ(testing::job_of(server.port(), running, "?wait=60").at("status"), "successful");
  EXPECT_EQ(server.end(SIGTERM), 0);
  const testing::ServerProcess again(path("data"));
  EXPECT_EQ(testing::wait_for_end(again.port(), waiting).at("attempt"), 1) << "it was not begun while stopping";
}

TEST_F(OperationsTest, a_job_that_was_given_back_at_a_stop_has_lost_nothing_but_time) {
  std::optional<testing::ServerProcess> server(std::in_place, path("data"),
                                               std::vector<std::string>{"--drain-time", "0"});
  const std::string id = testing::start_endless_job(*server, testing::random_points(20'000, 1));
  EXPECT_EQ(server->end(SIGTERM), 0);
  server.emplace(path("data"));
  const Json job = testing::wait_for_end(server->port(), id);
  EXPECT_EQ(job.at("status"), "successful");
  EXPECT_EQ(job.at("attempts").front().at("outcome"), "drained");
}

TEST_F(OperationsTest, the_numbers_of_the_service_are_there_for_prometheus) {
  const testing::ServerProcess server(path("data"));
  testing::wait_for_end(server.port(), submit(server.port(), cloud_));
  testing::wait_for_end(server.port(), submit(server.port(), "no cloud"));
  // A job has ended a moment before its worker is free.
  EXPECT_TRUE(testing::eventually([&] {
    return call(server.port(), "GET", "/metrics").body.find(R"(surfaced_jobs{status="running"} 0)") !=
           std::string::npos;
  }));
  const Answer answer = call(server.port(), "GET", "/metrics");
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.headers.at("content-type"), HasSubstr("text/plain; version=0.0.4"));
  for (const char* line : {R"(surfaced_attempts_total{method="advancing-front",outcome="done"} 1)",
                           R"(surfaced_attempts_total{method="advancing-front",outcome="input_invalid"} 1)",
                           R"(surfaced_http_requests_total{method="POST",route="/v1/jobs",status="201"} 2)",
                           R"(surfaced_stage_seconds_count{method="advancing-front",stage="read"})",
                           R"(surfaced_jobs{status="accepted"} 0)", "surfaced_ready 1", "surfaced_free_bytes",
                           "surfaced_oldest_accepted_seconds 0"}) {
    EXPECT_THAT(answer.body, HasSubstr(line));
  }
}

TEST_F(OperationsTest, log_lines_are_json_that_ties_request_job_and_trace_together) {
  const std::string trace = "0af7651916cd43dd8448eb211c80319c";
  environment_ = "";
  std::string request;
  std::string id;
  {
    // The server writes to the standard error of whoever starts it; a shell gives it a file.
    testing::ServerProcess server(path("data"), {"--log-format", "json"}, path("log"));
    const Answer answer = call(server.port(), "POST", "/v1/jobs?method=advancing-front", cloud_,
                               {{"traceparent", "00-" + trace + "-b7ad6b7169203331-01"}});
    request = answer.headers.at("x-request-id");
    id = Json::parse(answer.body).at("id");
    testing::wait_for_end(server.port(), id);
    EXPECT_EQ(server.end(SIGTERM), 0);
  }
  std::istringstream lines(text_of(path("log")));
  int requests = 0;
  int attempts = 0;
  for (std::string line; std::getline(lines, line);) {
    const Json json = Json::parse(line);
    EXPECT_TRUE(json.contains("time") && json.contains("level") && json.contains("message")) << line;
    if (json.value("request_id", "") != request) continue;
    EXPECT_EQ(json.at("trace_id"), trace) << line;
    requests += json.at("message") == "request" && json.at("status") == 201 ? 1 : 0;
    attempts += json.at("message") == "attempt ended" && json.at("job") == id ? 1 : 0;
  }
  EXPECT_EQ(requests, 1);
  EXPECT_EQ(attempts, 1);
}

TEST_F(OperationsTest, a_backup_of_a_running_service_can_be_served) {
  const testing::ServerProcess server(path("data"));
  const std::string done = submit(server.port(), cloud_);
  testing::wait_for_end(server.port(), done);
  const std::string mesh = "/v1/jobs/" + done + "/outputs/mesh.glb";
  const Answer before = call(server.port(), "GET", mesh);
  ASSERT_EQ(run("backup " + path("copy").string() + " --data " + path("data").string()), 0) << text_of(path("err"));
  EXPECT_THAT(text_of(path("out")), HasSubstr("copied and verified 1 jobs"));
  EXPECT_EQ(run("backup " + path("copy").string() + " --data " + path("data").string()), 2) << "it is not empty";
  EXPECT_EQ(run("backup --verify " + path("copy").string()), 0) << text_of(path("err"));
  EXPECT_THAT(text_of(path("out")), HasSubstr("verified 1 jobs"));
  EXPECT_EQ(run("backup --verify " + path("data").string()), 3) << "a data folder is no backup";
  // What happens after it is not in it.
  EXPECT_EQ(call(server.port(), "DELETE", "/v1/jobs/" + done).status, 200);
  const testing::ServerProcess restored(path("copy"));
  EXPECT_EQ(run("backup --verify " + path("copy").string()), 3) << "nor is one on which a service was started";
  const Answer after = call(restored.port(), "GET", mesh);
  EXPECT_EQ(after.status, 200);
  EXPECT_EQ(after.body, before.body);
  EXPECT_EQ(testing::job_of(restored.port(), done).at("status"), "successful");
  const std::string next = submit(restored.port(), cloud_);
  EXPECT_EQ(testing::wait_for_end(restored.port(), next).at("status"), "successful");
}

TEST_F(OperationsTest, files_are_not_swept_by_a_job_store_that_they_do_not_belong_to) {
  std::string id;
  {
    testing::ServerProcess server(path("data"));
    id = submit(server.port(), cloud_);
    testing::wait_for_end(server.port(), id);
    EXPECT_EQ(server.end(SIGTERM), 0);
  }
  std::filesystem::rename(path("data/jobs.sqlite"), path("kept.sqlite"));
  EXPECT_EQ(run("serve --listen 127.0.0.1:0 --data " + path("data").string()), 2);
  EXPECT_THAT(text_of(path("err")), HasSubstr("belong to the job store"));
  for (const char* tail : {"", "-wal", "-shm"}) std::filesystem::remove(path("data/jobs.sqlite").string() + tail);
  std::filesystem::rename(path("kept.sqlite"), path("data/jobs.sqlite"));
  const testing::ServerProcess server(path("data"));
  EXPECT_EQ(call(server.port(), "GET", "/v1/jobs/" + id + "/outputs/mesh.glb").status, 200);
}

TEST_F(OperationsTest, the_unit_for_systemd_is_one_that_systemd_understands) {
  if (run_shell("command -v systemd-analyze") != 0) GTEST_SKIP() << "there is no systemd-analyze here";
  std::string unit = text_of(SURFACED_SOURCE "/docker/surfaced.service");
  const std::string installed = "/usr/local/bin/surfaced";
  for (std::size_t at = 0; (at = unit.find("=" + installed)) != unit.npos;) {
    unit.replace(at + 1, installed.size(), SURFACED_BINARY);
  }
  std::ofstream(path("surfaced.service")) << unit;
  EXPECT_EQ(run_shell("systemd-analyze verify " + path("surfaced.service").string()), 0);
  EXPECT_EQ(text_of(path("err")), "");
}

}  // namespace
}  // namespace surfaced
