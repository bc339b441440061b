// SPDX-License-Identifier: GPL-3.0-or-later
// The real daemon over HTTP: clouds in, meshes out, wrong input refused, work cancelled.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <thread>

#include "support/gzip_files.hpp"
#include "support/limited_child.hpp"
#include "support/service_client.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;
using testing::Answer;

class ServiceTest : public ::testing::Test {
 protected:
  void SetUp() override { server_.emplace(directory_.path() / "data"); }

  Answer call(const std::string& method, const std::string& target, std::string_view body = {},
              const testing::Fields& fields = {}) const {
    return testing::call(server_->port(), method, target, body, fields);
  }
  std::string submit(std::string_view body, const std::string& query = "method=advancing-front") const {
    const Answer answer = call("POST", "/v1/jobs?" + query, body);
    EXPECT_EQ(answer.status, 201) << answer.body;
    return Json::parse(answer.body).at("id");
  }
  Json job(const std::string& id, const std::string& query = "") const {
    return testing::job_of(server_->port(), id, query);
  }
  Json wait_for_end(const std::string& id) const { return testing::wait_for_end(server_->port(), id); }
  static std::string code_of(const Answer& answer) { return testing::code_of(answer); }
  static std::string ply(const std::vector<Point3>& points) { return testing::binary_ply(points); }

  testing::TemporaryDirectory directory_;
  std::optional<testing::ServerProcess> server_;
};

TEST_F(ServiceTest, one_call_turns_a_cloud_into_a_mesh_with_a_report_beside_it) {
  const Answer answer =
      call("POST", "/v1/reconstruct?method=advancing-front&output=glb", ply(testing::torus_points(24, 60)));
  ASSERT_EQ(answer.status, 200) << answer.body;
  EXPECT_EQ(answer.headers.at("content-type"), "model/gltf-binary");
  EXPECT_EQ(answer.body.substr(0, 4), "glTF");
  const std::string link = answer.headers.at("link");
  const std::string path = link.substr(1, link.find('>') - 1);
  const Json report = Json::parse(call("GET", path).body);
  EXPECT_EQ(report.at("mesh").at("vertices"), 24 * 60);
  EXPECT_EQ(report.at("mesh").at("genus"), 1);
}

TEST_F(ServiceTest, the_mesh_comes_in_the_format_that_was_asked_for) {
  const Answer answer =
      call("POST", "/v1/reconstruct?method=advancing-front&output=ply", ply(testing::sphere_points(300)));
  ASSERT_EQ(answer.status, 200) << answer.body;
  EXPECT_EQ(answer.body.substr(0, 3), "ply");
  const std::string id = submit(ply(testing::sphere_points(300)), "method=advancing-front&outputs=mesh.drc");
  EXPECT_EQ(wait_for_end(id).at("status"), "successful");
  EXPECT_EQ(call("GET", "/v1/jobs/" + id + "/outputs/mesh.drc").body.substr(0, 5), "DRACO");
  EXPECT_EQ(call("GET", "/v1/jobs/" + id + "/outputs/mesh.glb").body.substr(0, 4), "glTF") << "made now";
}

TEST_F(ServiceTest, the_points_of_a_method_that_makes_some_come_beside_the_mesh) {
  const std::string id =
      submit(ply(testing::sphere_points(300)), "method=intrinsic-delaunay&outputs=mesh.drc,cloud.ply&upsample=jet");
  const Json ended = wait_for_end(id);
  EXPECT_EQ(ended.at("status"), "successful") << ended.dump();
  const Answer points = call("GET", "/v1/jobs/" + id + "/outputs/cloud.ply");
  EXPECT_EQ(points.status, 200);
  EXPECT_EQ(points.headers.at("content-type"), "application/octet-stream");
  EXPECT_EQ(points.body.substr(0, 3), "ply");
  EXPECT_EQ(call("GET", "/v1/jobs/" + id + "/outputs/mesh.drc").body.substr(0, 5), "DRACO");
}

TEST_F(ServiceTest, a_job_can_be_followed_fetched_in_parts_and_removed) {
  const std::string id = submit(ply(testing::sphere_points(500)));
  const Json ended = wait_for_end(id);
  EXPECT_EQ(ended.at("status"), "successful") << ended.dump();
  EXPECT_EQ(ended.at("progress"), 1.0);
  EXPECT_EQ(ended.at("attempt"), 1);
  const std::string mesh = "/v1/jobs/" + id + "/outputs/mesh.glb";
  const Answer whole = call("GET", mesh);
  ASSERT_EQ(whole.status, 200);
  const std::string etag = whole.headers.at("etag");
  const Answer tail = call("GET", mesh, {}, {{"Range", "bytes=100-"}, {"If-Range", etag}});
  EXPECT_EQ(tail.status, 206);
  EXPECT_EQ(tail.body, whole.body.substr(100));
  EXPECT_EQ(call("GET", mesh, {}, {{"If-None-Match", etag}}).status, 304);
  EXPECT_EQ(call("GET", mesh, {}, {{"Range", "bytes=999999999-"}}).status, 416);
  EXPECT_EQ(call("HEAD", mesh).headers.at("content-length"), std::to_string(whole.body.size()));
  EXPECT_EQ(call("GET", "/v1/jobs/" + id + "/outputs/secrets").status, 404);
  EXPECT_THAT(call("GET", "/v1/jobs/" + id + "/outputs/log.txt").body,
              ::testing::AllOf(HasSubstr("job " + id), HasSubstr("s of processor time and"),
                               HasSubstr("for 500 points with advancing-front"), HasSubstr("stage read "),
                               HasSubstr("outcome done")));
  EXPECT_EQ(call("DELETE", "/v1/jobs/" + id).status, 200);
  EXPECT_EQ(code_of(call("GET", "/v1/jobs/" + id)), "job_gone");
  EXPECT_EQ(call("GET", mesh).status, 410);
  EXPECT_FALSE(std::filesystem::exists(directory_.path() / "data/inputs" / id));
}

TEST_F(ServiceTest, the_same_points_in_any_order_give_the_same_bytes) {
  auto points = testing::torus_points(20, 50);
  const Answer first = call("POST", "/v1/reconstruct?method=advancing-front", ply(points));
  std::shuffle(points.begin(), points.end(), std::mt19937(7));
  const Answer second = call("POST", "/v1/reconstruct?method=advancing-front", ply(points));
  ASSERT_EQ(first.status, 200);
  EXPECT_EQ(first.headers.at("etag"), second.headers.at("etag"));
  EXPECT_EQ(first.body, second.body);
}

TEST_F(ServiceTest, bad_input_has_its_code_and_the_server_goes_on) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"text garbage", "unknown_format"},
      {std::string("\x89PNG\r\n\x1a\n", 8) + std::string(50, '\0'), "unknown_format"},
      {ply(testing::sphere_points(100)).substr(0, 500), "truncated_input"},
      {head + "nan 0 0\n1 inf 0\nnan 0 0\n0 0 nan\n", "coordinate_not_finite"},
      {head + "1 1 1\n1 1 1\n1 1 1\n1 1 1\n", "too_few_points"},
      {head + "0 0 0\n1 1 1\n2 2 2\n3 3 3\n", "collinear"},
  };
  for (const auto& [body, code] : cases) {
    const Answer direct = call("POST", "/v1/reconstruct?method=advancing-front", body);
    EXPECT_EQ(direct.status, 422) << direct.body;
    EXPECT_EQ(code_of(direct), code) << direct.body;
    const Json failed = wait_for_end(submit(body));
    EXPECT_EQ(failed.at("status"), "failed");
    EXPECT_EQ(failed.at("error").at("code"), code);
    EXPECT_EQ(failed.at("attempt"), 1);
    EXPECT_EQ(code_of(call("GET", "/v1/jobs/" + failed.at("id").get<std::string>() + "/outputs/mesh.glb")),
              "job_not_successful");
  }
  EXPECT_EQ(call("POST", "/v1/reconstruct?method=advancing-front", ply(testing::sphere_points(100))).status, 200);
}

TEST_F(ServiceTest, the_accept_header_chooses_the_format_of_the_mesh_unless_the_query_does) {
  const std::string body = ply(testing::sphere_points(100));
  const auto type_for = [&](const std::string& query, const std::string& accept) {
    const Answer answer = call("POST", "/v1/reconstruct?method=advancing-front" + query, body, {{"Accept", accept}});
    EXPECT_EQ(answer.status, 200) << answer.body;
    return answer.headers.at("content-type");
  };
  EXPECT_EQ(type_for("", "*/*"), "model/gltf-binary");
  EXPECT_EQ(type_for("", "model/stl"), "model/stl");
  EXPECT_EQ(type_for("", "model/obj;q=0.5, model/3mf"), "model/3mf");
  EXPECT_EQ(type_for("&output=obj", "model/stl"), "model/obj");
}

TEST_F(ServiceTest, a_cloud_is_taken_as_gzip_with_a_header_or_without) {
  const std::string body = ply(testing::sphere_points(100));
  const std::string packed = testing::gzipped(body);
  const std::string plain = call("POST", "/v1/reconstruct?method=advancing-front&output=ply", body).body;
  for (const auto& headers : std::vector<testing::Fields>{{}, {{"Content-Encoding", "gzip"}}}) {
    const Answer answer = call("POST", "/v1/reconstruct?method=advancing-front&output=ply", packed, headers);
    EXPECT_EQ(answer.status, 200) << answer.body;
    EXPECT_EQ(answer.body, plain);
  }
  // What is stored is what was sent.
  const Json stored = Json::parse(call("POST", "/v1/clouds", packed, {{"Content-Encoding", "gzip"}}).body);
  EXPECT_EQ(stored.at("id"), Json::parse(call("POST", "/v1/clouds", packed).body).at("id"));
}

TEST_F(ServiceTest, wrong_requests_are_refused_before_anything_is_stored) {
  const std::string body = ply(testing::sphere_points(100));
  EXPECT_EQ(code_of(call("POST", "/v1/jobs?method=magic", body)), "unknown_method");
  EXPECT_EQ(code_of(call("POST", "/v1/jobs?method=advancing-front&gamma=1", body)), "unknown_parameter");
  EXPECT_EQ(code_of(call("POST", "/v1/jobs?method=advancing-front&beta=%FF", body)), "invalid_request");
  EXPECT_EQ(code_of(call("POST", "/v1/jobs", body, {{"Content-Encoding", "br"}})), "unsupported_content_encoding");
  EXPECT_EQ(code_of(call("POST", "/v1/reconstruct", body, {{"Accept", "image/png"}})), "not_acceptable");
  EXPECT_EQ(code_of(call("POST", "/v1/jobs", "{}", {{"Content-Type", "application/json"}})), "invalid_request");
  EXPECT_EQ(code_of(call("POST", "/v1/jobs", "")), "empty_input");
  EXPECT_EQ(code_of(call("GET", "/v1/jobs/0123?wait=61")), "invalid_parameter");
  EXPECT_EQ(code_of(call("GET", "/v1/jobs/0123")), "job_not_found");
  for (const char* folder : {"inputs", "uploads", "attempts", "outputs"}) {
    EXPECT_TRUE(std::filesystem::is_empty(directory_.path() / "data" / folder)) << folder;
  }
}

TEST_F(ServiceTest, a_long_call_becomes_a_job) {
  server_.reset();
  server_.emplace(directory_.path() / "data", std::vector<std::string>{"--wait-limit", "0", "--workers", "1"});
  const std::string before = testing::start_endless_job(*server_, testing::random_points(30'000, 3));
  const Answer answer = call("POST", "/v1/reconstruct?method=advancing-front", ply(testing::sphere_points(20'000)));
  ASSERT_EQ(answer.status, 202) << answer.body;
  const std::string location = answer.headers.at("location");
  const std::string id = location.substr(location.rfind('/') + 1);
  EXPECT_EQ(code_of(call("GET", location + "/outputs/mesh.glb")), "not_finished");
  EXPECT_EQ(call("DELETE", "/v1/jobs/" + before).status, 202);
  EXPECT_EQ(wait_for_end(id).at("status"), "successful");
}

TEST_F(ServiceTest, dismissing_a_running_job_stops_its_process_within_two_seconds) {
  const std::string cloud = ply(testing::random_points(400'000, 1));
  const double seconds = testing::best_of_tries(2, [&] {
    const std::string id = submit(cloud);
    // A job runs from its claim on; its process comes a moment later.
    EXPECT_TRUE(testing::eventually([&] { return server_->children().size() == 1; }));
    const auto began = std::chrono::steady_clock::now();
    const Answer answer = call("DELETE", "/v1/jobs/" + id);
    EXPECT_EQ(answer.status, 202);
    EXPECT_EQ(Json::parse(answer.body).at("status"), "dismissed");
    EXPECT_TRUE(testing::eventually([&] { return server_->children().empty(); }));
    EXPECT_EQ(job(id).at("status"), "dismissed");
    return testing::seconds_since(began);
  });
  EXPECT_LT(seconds, 2);
}

TEST_F(ServiceTest, a_full_queue_is_told_with_retry_after) {
  server_.reset();
  server_.emplace(directory_.path() / "data", std::vector<std::string>{"--queue-limit", "1", "--workers", "1"});
  testing::start_endless_job(*server_, testing::random_points(30'000, 2));
  submit(ply(testing::sphere_points(100)));
  const Answer refused = call("POST", "/v1/jobs?method=advancing-front", ply(testing::sphere_points(100)));
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(code_of(refused), "queue_full");
  EXPECT_TRUE(refused.headers.contains("retry-after"));
}

TEST_F(ServiceTest, the_daemon_ends_with_0_when_it_is_told_to_stop) {
  server_.reset();
  server_.emplace(directory_.path() / "data", std::vector<std::string>{"--drain-time", "0"});
  const std::string id = submit(ply(testing::random_points(400'000, 3)));
  testing::wait_for_start(server_->port(), id);
  EXPECT_EQ(server_->end(SIGTERM), 0);
  server_.emplace(directory_.path() / "data");
  EXPECT_THAT(job(id).at("status").get<std::string>(), AnyOf("accepted", "running"));
  EXPECT_EQ(call("DELETE", "/v1/jobs/" + id).status, 202);
}

TEST_F(ServiceTest, a_large_upload_never_stands_in_memory) {
  // Declares what it holds, but with a coordinate that is refused: the child is soon done with it.
  std::string body = ply(std::vector<Point3>(6'000'000, Point3{std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  ASSERT_GT(body.size(), std::size_t{64} << 20);
  EXPECT_EQ(code_of(call("POST", "/v1/reconstruct?method=advancing-front", body)), "coordinate_not_finite");
  if (!testing::measuring_is_moot()) {
    EXPECT_LT(testing::peak_megabytes(server_->pid()), 50);
  }
}

TEST_F(ServiceTest, a_second_daemon_on_the_same_data_is_refused) {
  const std::string command = std::string(SURFACED_BINARY) + " serve --listen 127.0.0.1:0 --data " +
                              (directory_.path() / "data").string() + " 2> " + (directory_.path() / "err").string();
  // NOLINTNEXTLINE(concurrency-mt-unsafe): the test has one thread
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2);
  std::ifstream err(directory_.path() / "err");
  std::string line;
  std::getline(err, line);
  EXPECT_THAT(line, HasSubstr("in use by another surfaced"));
}

}  // namespace
}  // namespace surfaced
