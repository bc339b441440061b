// The service under real faults: kill -9 of server and child at random moments, a full disk, a locked store.
#include <gmock/gmock.h>
#include <sqlite3.h>
#include <sys/mount.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <random>
#include <set>
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

/// SURFACED_FAULTS=200 for the long form.
int number_of_faults() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody writes the environment
  const char* const text = std::getenv("SURFACED_FAULTS");
  return text == nullptr ? 12 : std::max(1, std::atoi(text));
}

/// Submits, and returns the id if the server said 201.
std::optional<std::string> try_to_submit(std::uint16_t port, const std::string& cloud) {
  try {
    const Answer answer = call(port, "POST", "/v1/jobs?method=advancing-front", cloud);
    if (answer.status != 201) return std::nullopt;
    return Json::parse(answer.body).at("id").get<std::string>();
  } catch (const std::exception&) {
    // No connection, or an answer that was cut off: it was not acknowledged.
    return std::nullopt;
  }
}

TEST(FaultTest, after_kills_of_server_and_children_at_random_moments_every_acknowledged_job_has_ended_once) {
  const testing::TemporaryDirectory directory;
  const auto data = directory.path() / "data";
  const std::vector<std::string> clouds{testing::binary_ply(testing::sphere_points(500)),
                                        testing::binary_ply(testing::sphere_points(2000))};
  std::mt19937 random(20);
  std::vector<std::pair<std::string, std::size_t>> acknowledged;
  std::set<std::string> tried_twice;
  std::optional<testing::ServerProcess> server(std::in_place, data);
  const int faults = number_of_faults();
  for (int fault = 0; fault < faults; ++fault) {
    for (int i = 0; i < 2; ++i) {
      const std::size_t cloud = random() % clouds.size();
      if (const auto id = try_to_submit(server->port(), clouds[cloud])) acknowledged.emplace_back(*id, cloud);
    }
    std::this_thread::sleep_for(milliseconds(random() % 60));
    if (random() % 2 == 0) {
      // A submission that is under way when the server dies may be acknowledged or not, but nothing else.
      std::optional<std::string> last;
      std::thread client([&, port = server->port()] { last = try_to_submit(port, clouds[0]); });
      std::this_thread::sleep_for(milliseconds(random() % 8));
      server->end(SIGKILL);
      client.join();
      if (last) acknowledged.emplace_back(*last, 0);
      server.emplace(data);
    } else {
      for (const pid_t child : server->children()) ::kill(child, SIGKILL);
    }
  }
  std::map<std::size_t, std::set<std::string>> meshes;
  int successful = 0;
  for (const auto& [id, cloud] : acknowledged) {
    Json job = testing::wait_for_end(server->port(), id);
    if (job.at("status") == "failed") {
      // Two kills of its child: it was parked by the rule, and starts anew when asked to.
      EXPECT_EQ(job.at("error").at("code"), "crashed") << job.dump();
      EXPECT_TRUE(job.at("parked").get<bool>()) << job.dump();
      EXPECT_EQ(call(server->port(), "POST", "/v1/jobs/" + id + "/retry").status, 202);
      job = testing::wait_for_end(server->port(), id);
    }
    ASSERT_EQ(job.at("status"), "successful") << job.dump();
    int done = 0;
    for (const Json& attempt : job.at("attempts")) {
      done += attempt.at("outcome") == "done" ? 1 : 0;
      EXPECT_THAT(attempt.at("outcome").get<std::string>(), AnyOf("done", "lost", "crashed"));
    }
    EXPECT_EQ(done, 1) << "it ended more than once: " << job.dump();
    const Answer mesh = call(server->port(), "GET", "/v1/jobs/" + id + "/outputs/mesh.glb");
    EXPECT_EQ(mesh.status, 200);
    meshes[cloud].insert(mesh.headers.at("etag") + mesh.body);
    ++successful;
  }
  for (const auto& [cloud, kinds] : meshes) EXPECT_EQ(kinds.size(), 1U) << "a cloud gave different meshes";
  EXPECT_GE(successful, faults);
  RecordProperty("faults", faults);
  RecordProperty("jobs", successful);
}

TEST(FaultTest, a_locked_store_is_answered_503_and_nothing_is_lost) {
  const testing::TemporaryDirectory directory;
  const auto data = directory.path() / "data";
  const testing::ServerProcess server(data);
  const std::string cloud = testing::binary_ply(testing::sphere_points(300));
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((data / "jobs.sqlite").c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  const Answer refused = call(server.port(), "POST", "/v1/jobs?method=advancing-front", cloud);
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(testing::code_of(refused), "not_ready");
  EXPECT_TRUE(refused.headers.contains("retry-after"));
  EXPECT_EQ(call(server.port(), "GET", "/readyz").status, 503);
  EXPECT_EQ(call(server.port(), "GET", "/healthz").status, 200);
  sqlite3_exec(other, "ROLLBACK", nullptr, nullptr, nullptr);
  sqlite3_close(other);
  EXPECT_EQ(call(server.port(), "GET", "/readyz").status, 200);
  EXPECT_EQ(call(server.port(), "POST", "/v1/reconstruct?method=advancing-front", cloud).status, 200);
}

/// A file system of its own, as small as a test needs.
class SmallDisk {
 public:
  SmallDisk(std::filesystem::path where, const std::string& size) : where_(std::move(where)) {
    std::filesystem::create_directories(where_);
    mounted_ = ::mount("tmpfs", where_.c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(where_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool mounted() const { return mounted_; }

 private:
  std::filesystem::path where_;
  bool mounted_;
};

TEST(FaultTest, a_full_disk_is_answered_507_before_anything_breaks_and_all_goes_on_when_there_is_space) {
  const testing::TemporaryDirectory directory;
  const SmallDisk disk(directory.path() / "disk", "24m");
  if (!disk.mounted()) GTEST_SKIP() << "mounting a file system is not allowed here";
  const auto data = directory.path() / "disk/data";
  const testing::ServerProcess server(data, {"--minimum-free", "4MiB", "--body-limit", "1GiB"});
  const std::string small = testing::binary_ply(testing::sphere_points(300));
  const Answer before = call(server.port(), "POST", "/v1/jobs?method=advancing-front", small);
  ASSERT_EQ(before.status, 201);
  const std::string id = Json::parse(before.body).at("id");
  EXPECT_EQ(testing::wait_for_end(server.port(), id).at("status"), "successful");

  const std::string large = testing::binary_ply(std::vector<Point3>(2'500'000));
  EXPECT_EQ(call(server.port(), "POST", "/v1/jobs?method=advancing-front", large).status, 507) << "by its length";
  {
    testing::RawConnection connection(server.port());
    connection.send("POST /v1/jobs?method=advancing-front HTTP/1.1\r\nHost: h\r\nTransfer-Encoding: chunked\r\n\r\n");
    const std::string chunk = "100000\r\n" + std::string(1 << 20, 'x') + "\r\n";
    for (int i = 0; i < 30 && connection.send(chunk); ++i) {
    }
    EXPECT_EQ(connection.read_answer().status, 507) << "on its way, without a length";
  }
  EXPECT_TRUE(std::filesystem::is_empty(data / "uploads"));

  std::ofstream(directory.path() / "disk/filler") << std::string(std::size_t{30} << 20, 'x');
  const Answer full = call(server.port(), "POST", "/v1/jobs?method=advancing-front", small);
  EXPECT_EQ(full.status, 507);
  EXPECT_EQ(testing::code_of(full), "storage_full");
  EXPECT_EQ(call(server.port(), "GET", "/readyz").status, 503);
  EXPECT_EQ(call(server.port(), "GET", "/v1/jobs/" + id + "/outputs/mesh.glb").status, 200);
  std::filesystem::remove(directory.path() / "disk/filler");
  EXPECT_EQ(call(server.port(), "GET", "/readyz").status, 200);
  EXPECT_EQ(call(server.port(), "POST", "/v1/reconstruct?method=advancing-front", small).status, 200);
}

TEST(FaultTest, jobs_that_run_while_the_disk_is_full_wait_for_space_instead_of_using_up_their_attempts) {
  const testing::TemporaryDirectory directory;
  const SmallDisk disk(directory.path() / "disk", "24m");
  if (!disk.mounted()) GTEST_SKIP() << "mounting a file system is not allowed here";
  const testing::ServerProcess server(directory.path() / "disk/data", {"--minimum-free", "2MiB", "--workers", "1"});
  const auto submit = [&](std::size_t points) {
    const Answer answer = call(server.port(), "POST", "/v1/jobs?method=advancing-front",
                               testing::binary_ply(testing::random_points(points, 5)));
    EXPECT_EQ(answer.status, 201) << answer.body;
    return Json::parse(answer.body).at("id").get<std::string>();
  };
  const std::string first = submit(40'000);
  const std::string second = submit(300);
  testing::wait_for_start(server.port(), first);
  std::ofstream(directory.path() / "disk/filler") << std::string(std::size_t{30} << 20, 'x');
  std::this_thread::sleep_for(std::chrono::seconds(4));
  std::filesystem::remove(directory.path() / "disk/filler");
  for (const std::string& id : {first, second}) {
    const Json job = testing::wait_for_end(server.port(), id);
    EXPECT_EQ(job.at("status"), "successful") << job.dump();
    EXPECT_LE(job.at("attempt"), 3) << job.dump();
  }
}

}  // namespace
}  // namespace surfaced
