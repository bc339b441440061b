// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "io/io.hpp"
#include "support/results.hpp"

namespace {

/// What syncing a folder fails with; 0 for not at all.
int folder_sync_error = 0;

}  // namespace

/// In the place of the C library's, for the whole program of the test.
extern "C" int fsync(int file) {
  struct stat status {};
  if (folder_sync_error != 0 && ::fstat(file, &status) == 0 && S_ISDIR(status.st_mode)) {
    errno = folder_sync_error;
    return -1;
  }
  return static_cast<int>(::syscall(SYS_fsync, file));
}

namespace surfaced {
namespace {

using namespace surfaced::testing;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// A folder of its own for each test.
class Files : public ::testing::Test {
 protected:
  Files() : folder_(fs::path(::testing::TempDir()) / ("surfaced_files_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~Files() override { fs::remove_all(folder_); }

  static std::string content(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::size_t entries() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {})); }

  fs::path folder_;
};

constexpr std::string_view kPly =
    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 "
    "3\n";

TEST_F(Files, a_written_file_replaces_the_old_one_and_leaves_nothing_else) {
  const fs::path path = folder_ / "a.ply";
  ASSERT_TRUE(write_file(path, testing::as_bytes("old")).ok());
  ASSERT_TRUE(write_file(path, testing::as_bytes("new and longer")).ok());
  EXPECT_EQ(content(path), "new and longer");
  EXPECT_EQ(entries(), 1U);
}

TEST_F(Files, a_folder_that_cannot_be_made_durable_is_told_of) {
  const fs::path path = folder_ / "a.ply";
  folder_sync_error = EIO;
  const Status failed = write_file(path, testing::as_bytes("new"));
  folder_sync_error = EINVAL;
  const Status not_syncable = write_file(path, testing::as_bytes("newer"));
  folder_sync_error = 0;
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().code, ErrorCode::output_not_writable);
  EXPECT_THAT(failed.error().detail, HasSubstr("a.ply"));
  EXPECT_TRUE(not_syncable.ok()) << "a file system that syncs no folders";
  EXPECT_EQ(content(path), "newer");
  EXPECT_EQ(entries(), 1U);
}

TEST_F(Files, a_link_stays_a_link_and_its_target_is_replaced) {
  ASSERT_TRUE(write_file(folder_ / "target", testing::as_bytes("old")).ok());
  fs::create_symlink("target", folder_ / "link");
  ASSERT_TRUE(write_file(folder_ / "link", testing::as_bytes("new")).ok());
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(content(folder_ / "target"), "new");
}

TEST_F(Files, a_device_is_written_to_and_not_replaced) {
  ASSERT_TRUE(write_file("/dev/null", testing::as_bytes("gone")).ok());
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(Files, a_place_that_cannot_be_written_is_named) {
  for (const fs::path& path : {folder_ / "no" / "such" / "folder.glb", folder_}) {
    const Status status = write_file(path, testing::as_bytes("x"));
    EXPECT_EQ(code_of(status), "output_not_writable");
    EXPECT_THAT(detail_of(status), HasSubstr(path.string()));
  }
}

TEST_F(Files, a_full_disk_is_an_error_and_leaves_the_old_file) {
  const Status status = write_file("/dev/full", testing::as_bytes("x"));
  EXPECT_EQ(code_of(status), "output_not_writable");
  EXPECT_THAT(detail_of(status), HasSubstr("space"));
}

TEST_F(Files, an_input_that_cannot_be_opened_is_named) {
  for (const fs::path& path : {folder_ / "missing.ply", folder_}) {
    const auto cloud = read_cloud(path);
    EXPECT_EQ(code_of(cloud), "input_unreadable");
    EXPECT_THAT(detail_of(cloud), HasSubstr(path.string()));
    EXPECT_EQ(code_of(read_mesh(path)), "input_unreadable");
  }
}

TEST_F(Files, an_empty_file_is_an_empty_input) {
  ASSERT_TRUE(write_file(folder_ / "empty.ply", {}).ok());
  EXPECT_EQ(code_of(read_cloud(folder_ / "empty.ply")), "empty_input");
  EXPECT_EQ(code_of(read_mesh(folder_ / "empty.ply")), "empty_input");
}

TEST_F(Files, a_pipe_is_read_to_its_end) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe, std::ios::binary) << kPly; });
  const auto cloud = read_cloud(pipe);
  writer.join();
  ASSERT_TRUE(cloud.ok()) << detail_of(cloud);
  EXPECT_EQ(cloud->positions[0], (Point3{1, 2, 3}));
}

TEST_F(Files, a_format_is_told_by_its_content_not_by_its_name) {
  ASSERT_TRUE(write_file(folder_ / "cloud.drc", testing::as_bytes(kPly)).ok());
  EXPECT_EQ(code_of(read_cloud(folder_ / "cloud.drc")), "ok");
}

TEST(MeshFormatOf, knows_the_extensions_in_any_case_and_lists_them) {
  EXPECT_EQ(mesh_format_of("a/b.glb").value(), MeshFormat::glb);
  EXPECT_EQ(mesh_format_of("b.GlTF").value(), MeshFormat::gltf);
  EXPECT_EQ(mesh_format_of("b.x.drc").value(), MeshFormat::drc);
  EXPECT_EQ(mesh_format_of("b.PLY").value(), MeshFormat::ply);
  for (const char* path : {"b", "b.step", "glb", ".glb", ""}) {
    const auto format = mesh_format_of(path);
    EXPECT_EQ(code_of(format), "unknown_output") << path;
    EXPECT_THAT(detail_of(format), HasSubstr(".glb, .gltf, .drc, .ply"));
  }
}

}  // namespace
}  // namespace surfaced
