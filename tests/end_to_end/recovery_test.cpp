// SPDX-License-Identifier: GPL-3.0-or-later
// What was acknowledged survives the death of the server.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <thread>

#include "support/service_client.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::json;
using testing::Answer;
using testing::call;

std::string ascii_ply(const std::vector<Point3>& points) {
  std::ostringstream text;
  text << "ply\nformat ascii 1.0\nelement vertex " << points.size()
       << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const Point3& point : points) text << point[0] << " " << point[1] << " " << point[2] << "\n";
  return text.str();
}

Json job(std::uint16_t port, const std::string& id, const std::string& query = "") {
  return Json::parse(call(port, "GET", "/v1/jobs/" + id + query).body);
}

std::size_t count(const std::filesystem::path& folder) {
  const std::filesystem::directory_iterator entries(folder);
  return static_cast<std::size_t>(std::distance(begin(entries), end(entries)));
}

/// Not gone, and not a dead process that nobody has reaped.
bool runs(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  if (!std::getline(file, text)) return false;
  return text[text.rfind(')') + 2] != 'Z';
}

TEST(RecoveryTest, killing_the_server_with_twenty_jobs_queued_loses_none_and_doubles_none) {
  const testing::TemporaryDirectory directory;
  const auto data = directory.path() / "data";
  const std::string cloud = ascii_ply(testing::sphere_points(3000));
  std::vector<std::string> ids;
  std::optional<testing::ServerProcess> server(std::in_place, data);
  for (int i = 0; i < 20; ++i) {
    const Answer answer = call(server->port(), "POST", "/v1/jobs?method=advancing-front", cloud);
    ASSERT_EQ(answer.status, 201) << answer.body;
    ids.push_back(Json::parse(answer.body).at("id"));
  }
  // Some have ended, some run, most wait.
  ASSERT_TRUE(testing::eventually([&] { return job(server->port(), ids[2]).at("status") == "successful"; },
                                  std::chrono::seconds(120)));
  std::map<std::string, std::string> ended_before;
  for (const auto& id : {ids[0], ids[1], ids[2]}) {
    const Answer mesh = call(server->port(), "GET", "/v1/jobs/" + id + "/outputs/mesh.glb");
    if (mesh.status == 200) ended_before[id] = mesh.headers.at("etag");
  }
  const auto children = server->children();
  EXPECT_EQ(server->end(SIGKILL), -SIGKILL);
  EXPECT_GE(ended_before.size(), 1U);

  server.emplace(data);
  std::map<std::string, int> etags;
  for (const auto& id : ids) {
    const Json now = testing::wait_for_end(server->port(), id);
    EXPECT_EQ(now.at("status"), "successful") << now.dump();
    EXPECT_LE(now.at("attempt"), 2) << "only what ran when the server died is tried again";
    const Answer mesh = call(server->port(), "GET", "/v1/jobs/" + id + "/outputs/mesh.glb");
    EXPECT_EQ(mesh.status, 200);
    ++etags[mesh.headers.at("etag")];
    if (ended_before.contains(id)) {
      EXPECT_EQ(now.at("attempt"), 1) << "an ended job ran again";
      EXPECT_EQ(mesh.headers.at("etag"), ended_before[id]);
    }
  }
  EXPECT_EQ(etags.size(), 1U) << "the same cloud gave different meshes";
  EXPECT_EQ(count(data / "outputs"), ids.size());
  EXPECT_EQ(count(data / "inputs"), ids.size());
  EXPECT_EQ(count(data / "attempts"), 0U);
  for (const pid_t child : children) EXPECT_FALSE(runs(child)) << "a child outlived its server";
}

TEST(RecoveryTest, killing_the_server_again_and_again_while_jobs_flow_loses_none) {
  const testing::TemporaryDirectory directory;
  const auto data = directory.path() / "data";
  const std::string cloud = ascii_ply(testing::sphere_points(500));
  std::vector<std::string> ids;
  for (int round = 0; round < 8; ++round) {
    testing::ServerProcess server(data);
    for (int i = 0; i < 3; ++i) {
      const Answer answer = call(server.port(), "POST", "/v1/jobs?method=advancing-front", cloud);
      ASSERT_EQ(answer.status, 201) << answer.body;
      ids.push_back(Json::parse(answer.body).at("id"));
    }
    // Between an early moment of the first attempt and the time when all three may have ended.
    std::this_thread::sleep_for(std::chrono::milliseconds(17 * round));
    server.end(SIGKILL);
  }
  testing::ServerProcess server(data);
  for (const auto& id : ids) {
    const Json now = testing::wait_for_end(server.port(), id);
    EXPECT_EQ(now.at("status"), "successful") << now.dump();
    EXPECT_EQ(call(server.port(), "GET", "/v1/jobs/" + id + "/outputs/report.json").status, 200);
  }
  EXPECT_EQ(count(data / "outputs"), ids.size());
}

TEST(RecoveryTest, files_that_no_job_refers_to_are_removed_at_the_start) {
  const testing::TemporaryDirectory directory;
  const auto data = directory.path() / "data";
  testing::ServerProcess(data).end(SIGTERM);
  std::ofstream(data / "inputs/orphan") << "x";
  std::ofstream(data / "uploads/half") << "x";
  std::ofstream(data / "partial" / (std::string(32, 'a') + ".bytes")) << "x";
  std::filesystem::create_directory(data / "outputs/0123-1");
  const testing::ServerProcess server(data);
  for (const char* room : {"inputs", "uploads", "outputs", "partial"}) EXPECT_EQ(count(data / room), 0U) << room;
}

TEST(RecoveryTest, an_upload_whose_server_died_between_its_last_byte_and_its_cloud_is_finished_at_the_start) {
  const testing::TemporaryDirectory directory;
  const auto data = directory.path() / "data";
  const std::string cloud = testing::binary_ply(testing::sphere_points(200));
  testing::Fields fields{{"Tus-Resumable", "1.0.0"}};
  std::string path;
  {
    testing::ServerProcess server(data);
    testing::Fields begin = fields;
    begin.emplace_back("Upload-Length", std::to_string(cloud.size()));
    path = call(server.port(), "POST", "/v1/uploads", "", begin).headers.at("location");
    server.end(SIGKILL);
  }
  // What a server leaves that has acknowledged every byte, to itself alone.
  std::ofstream(data / "partial" / (path.substr(path.rfind('/') + 1) + ".bytes"), std::ios::binary) << cloud;
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((data / "jobs.sqlite").c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database, "UPDATE uploads SET offset = length", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  const testing::ServerProcess server(data);
  Answer head;
  EXPECT_TRUE(testing::eventually([&] {
    head = call(server.port(), "HEAD", path, "", fields);
    return head.headers.contains("surfaced-cloud-id");
  }));
  EXPECT_EQ(call(server.port(), "GET", "/v1/clouds/" + head.headers["surfaced-cloud-id"]).status, 200);
  EXPECT_EQ(count(data / "partial"), 0U);
}

}  // namespace
}  // namespace surfaced
