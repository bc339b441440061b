// SPDX-License-Identifier: GPL-3.0-or-later
#include "uploads/upload_store.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <fstream>
#include <new>

#include "api/upload_headers.hpp"
#include "artifacts/backup_lease.hpp"
#include "jobs/sqlite_job_store.hpp"
#include "platform/files.hpp"
#include "support/artifacts_mock.hpp"
#include "support/patience.hpp"
#include "support/temporary_directory.hpp"
#include "uploads/finishing.hpp"

namespace surfaced {
namespace {

class UploadsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    jobs_ = open_sqlite_job_store(directory_.path() / "jobs.sqlite", {}).value();
    open({std::chrono::hours(1)});
  }
  void open(const UploadLimits& limits) { store_ = UploadStore::open(directory_.path(), limits).value(); }
  std::string begin(std::uint64_t length = 10) { return store_->create({"me"}, length, "name YQ==").value().id; }
  std::filesystem::path bytes_of(const std::string& id) const {
    return directory_.path() / "partial" / (id + ".bytes");
  }
  void append(const std::string& id, std::string_view text) {
    auto session = store_->begin(id).value();
    ASSERT_TRUE(session.write(as_bytes(text)).ok());
    ASSERT_TRUE(session.keep().ok());
  }
  std::string content(const std::string& id) {
    std::string text;
    const auto session = store_->begin(id).value();
    EXPECT_TRUE(session
                    .read([&](std::span<const std::byte> bytes) {
                      text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                      return Status(Done{});
                    })
                    .ok());
    return text;
  }

  testing::TemporaryDirectory directory_;
  std::unique_ptr<JobStore> jobs_;
  std::unique_ptr<UploadStore> store_;
};

TEST_F(UploadsTest, what_was_kept_survives_a_restart_and_what_was_not_is_cut_off) {
  const std::string id = begin();
  append(id, "abcd");
  {
    auto session = store_->begin(id).value();
    ASSERT_TRUE(session.write(as_bytes("xyz")).ok());
  }
  open({std::chrono::hours(1)});
  EXPECT_EQ(store_->find(id).value().offset, 4U);
  append(id, "efghij");
  EXPECT_TRUE(store_->find(id).value().whole());
  EXPECT_EQ(content(id), "abcdefghij");
}

TEST_F(UploadsTest, two_cannot_write_at_once) {
  const std::string id = begin();
  const auto first = store_->begin(id).value();
  EXPECT_EQ(store_->begin(id).error().code, ErrorCode::upload_busy);
}

TEST_F(UploadsTest, more_than_the_length_is_refused) {
  auto session = store_->begin(begin(3)).value();
  EXPECT_EQ(session.write(as_bytes("abcd")).error().code, ErrorCode::payload_too_large);
}

TEST_F(UploadsTest, ended_and_expired_uploads_are_gone_and_unknown_ones_were_never_there) {
  const std::string id = begin();
  ASSERT_TRUE(store_->begin(id).value().remove().ok());
  EXPECT_EQ(store_->find(id).error().code, ErrorCode::upload_gone);
  open({std::chrono::seconds(0)});
  const std::string late = begin();
  EXPECT_EQ(store_->find(late).error().code, ErrorCode::upload_gone);
  EXPECT_EQ(store_->sweep(), 1U);
  EXPECT_EQ(store_->begin(late).error().code, ErrorCode::upload_gone);
  for (const char* other : {"", "..", "../jobs.sqlite", "00000000000000000000000000000000"}) {
    EXPECT_EQ(store_->find(other).error().code, ErrorCode::upload_not_found) << other;
    EXPECT_EQ(store_->begin(other).error().code, ErrorCode::upload_not_found) << other;
  }
}

TEST_F(UploadsTest, unfinished_uploads_count_with_their_whole_length_until_they_end) {
  const std::string first = begin(10);
  begin(7);
  EXPECT_EQ(jobs_->holding_of("me").value().bytes, 17U);
  EXPECT_EQ(jobs_->holding_of("you").value().bytes, 0U);
  ASSERT_TRUE(store_->begin(first).value().remove().ok());
  EXPECT_EQ(jobs_->holding_of("me").value().bytes, 7U);
  EXPECT_EQ(store_->create({"me", "", {0, 20}}, 14, "").error().code, ErrorCode::quota_exceeded);
  EXPECT_TRUE(store_->create({"me", "", {0, 20}}, 13, "").ok());
}

TEST_F(UploadsTest, open_uploads_are_bounded_for_each_client_and_in_all) {
  open({std::chrono::hours(1), 3, 2});
  const std::string first = store_->create({"me", "me"}, 5, "").value().id;
  EXPECT_TRUE(store_->create({"me", "me"}, 5, "").ok());
  EXPECT_EQ(store_->create({"me", "me"}, 5, "").error().code, ErrorCode::too_many_requests);
  EXPECT_TRUE(store_->create({"you", "you"}, 5, "").ok());
  EXPECT_EQ(store_->create({"them", ""}, 5, "").error().code, ErrorCode::not_ready);
  ASSERT_TRUE(store_->begin(first).value().remove().ok());
  EXPECT_TRUE(store_->create({"me", "me"}, 5, "").ok()) << "one that has ended leaves its place";
}

TEST_F(UploadsTest, a_sweep_removes_every_file_that_no_open_upload_has) {
  const std::string open = begin();
  append(open, "abcd");
  const std::string ended = begin();
  append(ended, "abcd");
  ASSERT_TRUE(store_->begin(ended).value().remove().ok());
  EXPECT_FALSE(std::filesystem::exists(bytes_of(ended)));
  for (const std::string& name : {ended + ".bytes", std::string(32, '0') + ".bytes", std::string("x.json.new")}) {
    std::ofstream(directory_.path() / "partial" / name) << "left by a crash";
  }
  store_->sweep();
  std::vector<std::filesystem::path> left;
  for (const auto& entry : std::filesystem::directory_iterator(directory_.path() / "partial")) left.push_back(entry);
  EXPECT_THAT(left, ::testing::ElementsAre(bytes_of(open)));
}

TEST_F(UploadsTest, nothing_is_removed_while_a_backup_is_made_and_the_sweep_after_it_finds_it) {
  const std::string id = begin();
  append(id, "abcd");
  {
    const auto lease = BackupLease::take(directory_.path()).value();
    ASSERT_TRUE(store_->begin(id).value().remove().ok());
    store_->sweep();
    EXPECT_TRUE(std::filesystem::exists(bytes_of(id)));
  }
  store_->sweep();
  EXPECT_FALSE(std::filesystem::exists(bytes_of(id)));
}

TEST_F(UploadsTest, an_upload_whose_bytes_were_lost_is_gone_and_not_filled_with_zeros) {
  const std::string id = begin();
  append(id, "abcd");
  std::filesystem::resize_file(bytes_of(id), 2);
  EXPECT_EQ(store_->begin(id).error().code, ErrorCode::upload_gone);
  EXPECT_EQ(store_->find(id).error().code, ErrorCode::upload_gone);
  EXPECT_EQ(jobs_->holding_of("me").value().bytes, 0U);
}

TEST_F(UploadsTest, uploads_that_a_version_before_kept_as_files_go_on) {
  const std::string id(32, 'a');
  std::ofstream(directory_.path() / "partial" / (id + ".json"))
      << R"({"id":")" << id
      << R"(","owner":"me","length":10,"offset":4,"metadata":"","created_at":"2026-01-01T00:00:00Z",)"
      << R"("expires_at":"2999-01-01T00:00:00Z","cloud":"","gone":false})";
  std::ofstream(bytes_of(id)) << "abcd and what did not count";
  open({std::chrono::hours(1)});
  append(id, "efghij");
  EXPECT_EQ(content(id), "abcdefghij");
  EXPECT_EQ(jobs_->holding_of("me").value().bytes, 10U);
  EXPECT_FALSE(std::filesystem::exists(directory_.path() / "partial" / (id + ".json")));
}

TEST_F(UploadsTest, a_record_that_cannot_be_read_stays_with_its_bytes_through_starts_and_sweeps) {
  const std::string id(32, 'b');
  const auto record = directory_.path() / "partial" / (id + ".json");
  const std::string whole = R"({"id":")" + id + R"(","owner":"me","length":10,"offset":4,"metadata":"","cloud":"",)" +
                            R"("created_at":"2026-01-01T00:00:00Z","expires_at":"2999-01-01T00:00:00Z","gone":false})";
  const std::string strange = R"({"id":"../)" + whole.substr(10);
  for (const std::string& damaged : {std::string(), whole.substr(0, 60), std::string("[]"), strange}) {
    std::ofstream(record) << damaged;
    std::ofstream(bytes_of(id)) << "abcd";
    open({std::chrono::hours(1)});
    store_->sweep();
    EXPECT_EQ(std::filesystem::file_size(record), damaged.size());
    ASSERT_TRUE(std::filesystem::exists(bytes_of(id))) << damaged;
    EXPECT_EQ(std::filesystem::file_size(bytes_of(id)), 4U);
  }
  std::ofstream(record) << whole;
  open({std::chrono::hours(1)});
  EXPECT_EQ(content(id), "abcd") << "once it was mended it goes on";
}

TEST_F(UploadsTest, what_is_thrown_while_an_upload_is_finished_costs_no_thread) {
  const std::string id = begin(4);
  append(id, "abcd");
  ::testing::NiceMock<testing::ArtifactsMock> artifacts;
  std::atomic<int> calls = 0;
  ON_CALL(artifacts, check_space(::testing::_)).WillByDefault([&](std::uint64_t) -> Status {
    if (++calls == 1) throw std::bad_alloc();
    return Error{ErrorCode::storage_full, "full"};
  });
  const auto clouds = open_sqlite_cloud_store(directory_.path() / "jobs.sqlite").value();
  const SideTask task(artifacts, {"/nonexistent"}, {});
  CloudInspector inspector(*clouds, artifacts, task);
  CloudService service(*clouds, artifacts, inspector);
  UploadFinishing finishing(*store_, artifacts, service);
  finishing.start();
  EXPECT_TRUE(testing::eventually([&] { return calls > 0; }));
  finishing.wake();
  EXPECT_TRUE(testing::eventually([&] { return calls > 1; }));
}

TEST(UploadHeadersTest, checksums_have_an_algorithm_and_its_length) {
  http::Headers headers;
  headers.add("Upload-Checksum", "sha1 Kq5sNclPz7QV2+lfQIuc6R7oRu0=");
  EXPECT_EQ(api::checksum_header(headers).value()->digest.size(), 20U);
  for (const char* wrong : {"sha1", "sha1 ", "sha1 Kq5s", "crc9 Kq5sNclPz7QV2+lfQIuc6R7oRu0=", "sha1 !!", " "}) {
    http::Headers other;
    other.add("Upload-Checksum", wrong);
    EXPECT_FALSE(api::checksum_header(other).ok()) << wrong;
  }
}

TEST(UploadHeadersTest, metadata_is_pairs_of_a_name_and_base64) {
  const auto ok = [](const std::string& text) {
    http::Headers headers;
    headers.add("Upload-Metadata", text);
    return api::metadata_header(headers).ok();
  };
  EXPECT_TRUE(ok("filename YS5wbHk=,is_confidential"));
  EXPECT_TRUE(ok(""));
  EXPECT_FALSE(ok("filename a.ply"));
  EXPECT_FALSE(ok(",x"));
  EXPECT_FALSE(ok(std::string(5000, 'a')));
}

}  // namespace
}  // namespace surfaced
