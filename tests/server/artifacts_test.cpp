// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <sqlite3.h>

#include <fstream>

#include "artifacts/file_artifact_store.hpp"
#include "artifacts/orphans.hpp"
#include "jobs/sqlite_job_store.hpp"
#include "platform/files.hpp"
#include "support/temporary_directory.hpp"

namespace surfaced {
namespace {

using ::testing::HasSubstr;

class ArtifactsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto opened = open_file_artifact_store(root(), 0);
    ASSERT_TRUE(opened.ok()) << opened.error().detail;
    store_ = std::move(*opened);
  }
  const std::filesystem::path& root() const { return directory_.path(); }

  StoredInput store_input(const std::string& key, std::string_view content) {
    auto upload = store_->begin_upload().value();
    EXPECT_TRUE(upload->write(as_bytes(content)).ok());
    return upload->commit(key).value();
  }
  void write_attempt(const Claim& claim, const std::string& name, const std::string& content) {
    std::ofstream(root() / "attempts" / (claim.job + "-" + std::to_string(claim.attempt)) / name) << content;
  }
  std::size_t count(const char* folder) const {
    const std::filesystem::directory_iterator entries(root() / folder);
    return static_cast<std::size_t>(std::distance(begin(entries), end(entries)));
  }

  testing::TemporaryDirectory directory_;
  std::unique_ptr<ArtifactStore> store_;
};

TEST_F(ArtifactsTest, an_upload_is_kept_with_its_size_and_hash) {
  const StoredInput input = store_input("k", "abc");
  EXPECT_EQ(input.bytes, 3U);
  EXPECT_EQ(input.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  std::ifstream file(store_->input_file("k").value());
  std::string content;
  file >> content;
  EXPECT_EQ(content, "abc");
  EXPECT_EQ(count("uploads"), 0U);
}

TEST_F(ArtifactsTest, an_upload_that_is_given_up_leaves_nothing) {
  {
    auto upload = store_->begin_upload().value();
    EXPECT_TRUE(upload->write(as_bytes("half")).ok());
    EXPECT_EQ(count("uploads"), 1U);
  }
  EXPECT_EQ(count("uploads"), 0U);
  EXPECT_EQ(count("inputs"), 0U);
}

TEST_F(ArtifactsTest, publishing_keeps_the_named_files_and_nothing_else) {
  const Claim claim{"job", 3};
  store_->begin_attempt(claim).value();
  write_attempt(claim, "mesh.glb", "mesh");
  write_attempt(claim, "core", "litter");
  const auto outputs = store_->publish(claim, std::vector<std::string>{"mesh.glb", "report.json"}).value();
  ASSERT_EQ(outputs.size(), 1U);
  EXPECT_EQ(outputs.front().name, "mesh.glb");
  EXPECT_EQ(outputs.front().attempt, 3U);
  EXPECT_EQ(outputs.front().bytes, 4U);
  EXPECT_EQ(count("attempts"), 0U);
  EXPECT_FALSE(std::filesystem::exists(root() / "outputs/job-3/core"));
  auto reader = store_->open_output(claim, "mesh.glb").value();
  std::array<std::byte, 16> buffer{};
  EXPECT_EQ(reader->size(), 4U);
  EXPECT_EQ(reader->read(1, buffer).value(), 3U);
}

TEST_F(ArtifactsTest, a_link_or_a_folder_in_place_of_an_output_is_refused) {
  const Claim claim{"job", 1};
  store_->begin_attempt(claim).value();
  std::filesystem::create_symlink("/etc/passwd", root() / "attempts/job-1/mesh.glb");
  EXPECT_EQ(store_->publish(claim, std::vector<std::string>{"mesh.glb"}).error().code, ErrorCode::crashed);
  std::filesystem::remove(root() / "attempts/job-1/mesh.glb");
  std::filesystem::create_directory(root() / "attempts/job-1/mesh.glb");
  EXPECT_EQ(store_->publish(claim, std::vector<std::string>{"mesh.glb"}).error().code, ErrorCode::crashed);
}

TEST_F(ArtifactsTest, a_data_directory_that_cannot_be_made_is_named) {
  std::ofstream(root() / "file") << "x";
  const auto lock = DataLock::acquire(root() / "file/data");
  ASSERT_FALSE(lock.ok());
  EXPECT_EQ(lock.error().code, ErrorCode::output_not_writable);
  EXPECT_THAT(lock.error().detail, HasSubstr((root() / "file/data").string()));
}

TEST_F(ArtifactsTest, attempts_of_a_job_do_not_touch_each_other) {
  const std::vector<std::string> names{"mesh.glb"};
  for (const std::uint32_t attempt : {1U, 2U}) {
    store_->begin_attempt({"job", attempt}).value();
    write_attempt({"job", attempt}, "mesh.glb", std::to_string(attempt));
  }
  EXPECT_TRUE(store_->publish({"job", 2}, names).ok());
  EXPECT_TRUE(store_->publish({"job", 1}, names).ok());
  store_->discard({"job", 1});
  EXPECT_EQ(store_->open_output({"job", 2}, "mesh.glb").value()->size(), 1U);
  EXPECT_FALSE(store_->open_output({"job", 1}, "mesh.glb").ok());
}

TEST_F(ArtifactsTest, the_sweep_removes_what_no_job_refers_to_and_keeps_the_rest) {
  store_input("kept", "a");
  store_input("orphan", "b");
  for (const char* job : {"kept", "orphan"}) {
    store_->begin_attempt({job, 1}).value();
    write_attempt({job, 1}, "mesh.glb", "x");
    store_->publish({job, 1}, std::vector<std::string>{"mesh.glb"}).value();
  }
  store_->begin_attempt({"kept", 2}).value();
  std::ofstream(root() / "uploads/half") << "half";
  EXPECT_EQ(store_->sweep({{"kept"}, {{"kept", 1}}}).value(), 4U);
  EXPECT_EQ(count("inputs") + count("outputs"), 2U);
  EXPECT_EQ(count("uploads") + count("attempts"), 0U);
  EXPECT_TRUE(store_->open_output({"kept", 1}, "mesh.glb").ok());
}

TEST_F(ArtifactsTest, too_little_free_space_is_told_with_numbers) {
  const auto greedy = open_file_artifact_store(root(), ~std::uint64_t{0}).value();
  const Status space = greedy->check_space(0);
  EXPECT_EQ(space.error().code, ErrorCode::storage_full);
  EXPECT_THAT(space.error().detail, HasSubstr("18446744073709551615"));
  EXPECT_TRUE(store_->check_space(0).ok());
}

TEST_F(ArtifactsTest, a_cloud_that_would_use_up_the_space_is_refused_before_it_is_sent_and_while_it_arrives) {
  const std::uint64_t free = store_->free_bytes();
  const auto tight = open_file_artifact_store(root(), free - (std::uint64_t{20} << 20)).value();
  EXPECT_TRUE(tight->check_space(std::uint64_t{1} << 20).ok());
  EXPECT_EQ(tight->check_space(std::uint64_t{30} << 20).error().code, ErrorCode::storage_full);
  // Whoever does not say how much will come is stopped on the way.
  auto upload = tight->begin_upload().value();
  const std::string piece(std::size_t{1} << 20, 'x');
  Status written = Done{};
  for (int i = 0; i < 64 && written; ++i) written = upload->write(as_bytes(piece));
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::storage_full);
  upload.reset();
  EXPECT_EQ(count("uploads") + count("inputs"), 0U);
}

TEST_F(ArtifactsTest, files_of_another_job_store_are_never_touched) {
  EXPECT_TRUE(store_->belong_to("one").ok());
  EXPECT_TRUE(store_->belong_to("one").ok());
  const Status other = store_->belong_to("two");
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().code, ErrorCode::invalid_usage);
  EXPECT_THAT(other.error().detail, HasSubstr("belong to the job store 'one'"));
}

/// The store and the job store together.
class OrphanTest : public ArtifactsTest {
 protected:
  void SetUp() override {
    ArtifactsTest::SetUp();
    jobs_ = open_sqlite_job_store(root() / "jobs.sqlite", {}).value();
    sweep_ = std::make_unique<OrphanSweep>(*jobs_, *store_);
  }
  void submit(const std::string& id) {
    const NewJob job{id, "m", {}, store_input(id, "cloud"), {"mesh.glb"}, "r", "", std::chrono::hours(1)};
    EXPECT_TRUE(jobs_->submit(job).ok());
  }
  void publish(const Claim& claim) {
    store_->begin_attempt(claim).value();
    write_attempt(claim, "mesh.glb", "x");
    store_->publish(claim, std::vector<std::string>{"mesh.glb"}).value();
  }
  std::unique_ptr<JobStore> jobs_;
  std::unique_ptr<OrphanSweep> sweep_;
};

TEST_F(OrphanTest, what_no_job_knows_is_removed_at_the_second_look) {
  submit("known");
  store_input("orphan", "cloud");
  publish({"orphan", 1});
  EXPECT_EQ(sweep_->look().value(), 0U);
  EXPECT_EQ(sweep_->look().value(), 2U);
  EXPECT_EQ(count("inputs"), 1U);
  EXPECT_EQ(count("outputs"), 0U);
}

TEST_F(OrphanTest, what_is_on_its_way_between_the_stores_is_kept) {
  store_input("late", "cloud");
  EXPECT_EQ(sweep_->look().value(), 0U);
  submit("late");
  EXPECT_EQ(sweep_->look().value(), 0U);
  // Outputs that are published and not settled yet, for as long as the store cannot be written.
  const Claim claim = jobs_->claim().value().value().claim();
  publish(claim);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(sweep_->look().value(), 0U);
  EXPECT_EQ(count("inputs") + count("outputs"), 2U);
}

TEST_F(OrphanTest, without_an_answer_of_the_job_store_nothing_is_removed) {
  store_input("orphan", "cloud");
  EXPECT_EQ(sweep_->look().value(), 0U);
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((root() / "jobs.sqlite").c_str(), &other), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(other, "DROP TABLE outputs", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(other);
  EXPECT_FALSE(sweep_->look().ok());
  EXPECT_EQ(count("inputs"), 1U);
}

TEST_F(ArtifactsTest, a_data_directory_is_held_by_one_server) {
  const auto held = DataLock::acquire(root());
  ASSERT_TRUE(held.ok());
  const auto second = DataLock::acquire(root());
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::invalid_usage);
  EXPECT_THAT(second.error().detail, HasSubstr("in use by another surfaced"));
}

TEST(EntriesTest, are_all_that_a_folder_has_and_an_error_where_it_cannot_be_read) {
  const testing::TemporaryDirectory directory;
  std::ofstream(directory.path() / "a") << "x";
  std::filesystem::create_directory(directory.path() / "b");
  EXPECT_THAT(entries_of(directory.path()).value(),
              ::testing::UnorderedElementsAre(directory.path() / "a", directory.path() / "b"));
  EXPECT_EQ(entries_of(directory.path() / "a").error().code, ErrorCode::internal_error);
  EXPECT_EQ(entries_of(directory.path() / "none").error().code, ErrorCode::internal_error);
}

}  // namespace
}  // namespace surfaced
