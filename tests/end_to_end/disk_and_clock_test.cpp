// SPDX-License-Identifier: GPL-3.0-or-later
// The store locked, the disk full, the clock wrong.
#include <gmock/gmock.h>
#include <sqlite3.h>
#include <sys/mount.h>

#include <cstdlib>
#include <fstream>
#include <optional>
#include <thread>

#include "support/limited_child.hpp"
#include "support/service_client.hpp"
#include "support/shapes.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::json;
using testing::Answer;
using testing::call;

TEST(DiskAndClockTest, a_locked_store_is_answered_503_and_nothing_is_lost) {
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

TEST(DiskAndClockTest, a_full_disk_is_answered_507_before_anything_breaks_and_all_goes_on_when_there_is_space) {
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

std::string begin_upload(std::uint16_t port, std::size_t bytes) {
  const Answer begun =
      call(port, "POST", "/v1/uploads", "", {{"Tus-Resumable", "1.0.0"}, {"Upload-Length", std::to_string(bytes)}});
  EXPECT_EQ(begun.status, 201) << begun.body;
  return begun.headers.at("location");
}

/// Sends a part of an upload in chunks of 1 MiB, which do not say how many come; the status of the answer.
int send_in_chunks(std::uint16_t port, const std::string& upload, int chunks) {
  testing::RawConnection connection(port);
  connection.send("PATCH " + upload +
                  " HTTP/1.1\r\nHost: h\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: 0\r\nContent-Type: "
                  "application/offset+octet-stream\r\nTransfer-Encoding: chunked\r\n\r\n");
  const std::string chunk = "100000\r\n" + std::string(1 << 20, 'x') + "\r\n";
  for (int i = 0; i < chunks && connection.send(chunk); ++i) {
  }
  connection.send("0\r\n\r\n");
  return connection.read_answer().status;
}

TEST(DiskAndClockTest, uploads_that_do_not_say_how_much_comes_leave_free_what_is_to_stay_free) {
  const testing::TemporaryDirectory directory;
  const SmallDisk disk(directory.path() / "disk", "24m");
  if (!disk.mounted()) GTEST_SKIP() << "mounting a file system is not allowed here";
  const testing::ServerProcess server(directory.path() / "disk/data", {"--minimum-free", "8MiB"});
  // Each could be stored alone.
  const std::string first = begin_upload(server.port(), std::size_t{12} << 20);
  const std::string second = begin_upload(server.port(), std::size_t{12} << 20);
  EXPECT_EQ(send_in_chunks(server.port(), first, 9), 204);
  EXPECT_EQ(send_in_chunks(server.port(), second, 9), 507);
  EXPECT_GE(std::filesystem::space(directory.path() / "disk").available, std::size_t{8} << 20);
  const Answer kept = call(server.port(), "HEAD", second, "", {{"Tus-Resumable", "1.0.0"}});
  EXPECT_GT(std::stoull(kept.headers.at("upload-offset")), std::size_t{1} << 20) << "what there was space for counts";
}

TEST(DiskAndClockTest, jobs_that_run_while_the_disk_is_full_wait_for_space_instead_of_using_up_their_attempts) {
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
  // Long enough for the first to fail at writing, and to be tried too often if nobody waited.
  std::this_thread::sleep_for(std::chrono::seconds(4));
  std::filesystem::remove(directory.path() / "disk/filler");
  for (const std::string& id : {first, second}) {
    const Json job = testing::wait_for_end(server.port(), id);
    EXPECT_EQ(job.at("status"), "successful") << job.dump();
    EXPECT_LE(job.at("attempt"), 3) << job.dump();
  }
}

/// A server whose time of day can be changed.
class ShiftedServer {
 public:
  explicit ShiftedServer(const std::filesystem::path& directory) : file_(directory / "offset") {
    jump(0);
    // NOLINTBEGIN(concurrency-mt-unsafe): the test has one thread
    ::setenv("SHIFTED_CLOCK", file_.c_str(), 1);
    ::setenv("LD_PRELOAD", SURFACED_SHIFTED_CLOCK, 1);
    server_.emplace(directory / "data", std::vector<std::string>{"--lease", "9", "--workers", "1"});
    ::unsetenv("LD_PRELOAD");
    ::unsetenv("SHIFTED_CLOCK");
    // NOLINTEND(concurrency-mt-unsafe)
  }
  void jump(std::int64_t seconds) const {
    std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
    if (!file) file.open(file_, std::ios::out | std::ios::binary);
    file.write(reinterpret_cast<const char*>(&seconds), sizeof seconds);
  }
  const testing::ServerProcess& process() const { return *server_; }
  std::uint16_t port() const { return server_->port(); }

 private:
  std::filesystem::path file_;
  std::optional<testing::ServerProcess> server_;
};

TEST(DiskAndClockTest, a_clock_that_jumps_by_hours_either_way_ends_no_job_and_loses_none) {
  if (testing::measuring_is_moot()) GTEST_SKIP() << "a sanitizer has to be the first library";
  const testing::TemporaryDirectory directory;
  const ShiftedServer server(directory.path());
  const auto submit = [&](std::size_t points) {
    const Answer answer = call(server.port(), "POST", "/v1/jobs?method=advancing-front",
                               testing::binary_ply(testing::random_points(points, 7)));
    EXPECT_EQ(answer.status, 201) << answer.body;
    return Json::parse(answer.body);
  };
  const std::string running = testing::start_endless_job(server.process(), testing::random_points(20'000, 7));
  std::vector<Json> others;
  for (const std::int64_t hours : {5, -5, 3}) {
    server.jump(hours * 3600);
    others.push_back(submit(200));
    // Leases are looked at every third of their time.
    std::this_thread::sleep_for(std::chrono::milliseconds(3200));
  }
  EXPECT_GT(others[0].at("created_at"), others[1].at("created_at")) << "the clock did jump";
  for (const pid_t child : server.process().children()) ::kill(-child, SIGCONT);
  others.push_back(testing::job_of(server.port(), running));
  for (const Json& each : others) {
    const Json job = testing::wait_for_end(server.port(), each.at("id"));
    EXPECT_EQ(job.at("status"), "successful") << job.dump();
    EXPECT_EQ(job.at("attempt"), 1) << job.dump();
    EXPECT_EQ(call(server.port(), "GET", "/v1/jobs/" + job.at("id").get<std::string>() + "/outputs/mesh.glb").status,
              200);
  }
  EXPECT_EQ(call(server.port(), "GET", "/readyz").status, 200);
}

}  // namespace
}  // namespace surfaced
