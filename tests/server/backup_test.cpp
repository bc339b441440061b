// SPDX-License-Identifier: GPL-3.0-or-later
// What a backup has, and when it says so.
#include "backup/backup.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <fstream>
#include <functional>
#include <thread>

#include "artifacts/backup_lease.hpp"
#include "artifacts/file_artifact_store.hpp"
#include "artifacts/orphans.hpp"
#include "clouds/cloud_store.hpp"
#include "jobs/sqlite_job_store.hpp"
#include "platform/files.hpp"
#include "platform/random.hpp"
#include "support/temporary_directory.hpp"
#include "uploads/upload_store.hpp"

namespace surfaced {
namespace {

using ::testing::HasSubstr;

class BackupTest : public ::testing::Test {
 protected:
  void SetUp() override {
    jobs_ = open_sqlite_job_store(data() / "jobs.sqlite", {}).value();
    clouds_ = open_sqlite_cloud_store(data() / "jobs.sqlite").value();
    uploads_ = UploadStore::open(data(), {std::chrono::hours(1)}).value();
    artifacts_ = open_file_artifact_store(data(), 0).value();
    ASSERT_TRUE(artifacts_->belong_to(jobs_->identity().value()).ok());
  }
  std::filesystem::path data() const {
    std::filesystem::create_directories(directory_.path() / "data");
    return directory_.path() / "data";
  }
  std::filesystem::path copy() const { return directory_.path() / "copy"; }

  StoredInput store(std::string_view bytes, const std::string& key = "") {
    auto upload = artifacts_->begin_upload().value();
    EXPECT_TRUE(upload->write(as_bytes(bytes)).ok());
    return upload->commit(key.empty() ? upload->sha256() : key).value();
  }
  /// A successful job with a mesh and a log.
  Job finish_a_job() {
    NewJob job;
    job.id = random_hex<16>();
    job.method = "m";
    job.parameters = nlohmann::ordered_json::object();
    job.input = store("a cloud of " + job.id, job.id);
    job.wanted = {"mesh.glb", "log.txt"};
    job.ttl = std::chrono::hours(1);
    EXPECT_TRUE(jobs_->submit(job).ok());
    const Claim claim = jobs_->claim().value()->claim();
    const auto folder = artifacts_->begin_attempt(claim).value();
    for (const std::string& name : job.wanted) std::ofstream(folder / name) << name << " of " << job.id;
    Ending ending;
    ending.outcome = Outcome::done;
    ending.outputs = artifacts_->publish(claim, job.wanted).value();
    EXPECT_EQ(jobs_->settle(claim, ending).value(), JobStatus::successful);
    return jobs_->find(job.id).value();
  }
  std::string begin_an_upload() {
    const std::string id = uploads_->create({"me"}, 10, "").value().id;
    auto session = uploads_->begin(id).value();
    EXPECT_TRUE(session.write(as_bytes("abcd")).ok());
    EXPECT_TRUE(session.keep().ok());
    return id;
  }
  std::filesystem::path mesh_of(const Job& job) const {
    return std::filesystem::path("outputs") / (job.id + "-1") / "mesh.glb";
  }
  static std::string damage(const Result<BackupContents>& backup) {
    EXPECT_FALSE(backup.ok());
    if (backup.ok()) return "";
    EXPECT_EQ(backup.error().code, ErrorCode::malformed_input) << backup.error().detail;
    return backup.error().detail;
  }

  testing::TemporaryDirectory directory_;
  std::unique_ptr<JobStore> jobs_;
  std::unique_ptr<CloudStore> clouds_;
  std::unique_ptr<UploadStore> uploads_;
  std::unique_ptr<ArtifactStore> artifacts_;
};

TEST_F(BackupTest, a_backup_has_jobs_clouds_and_unfinished_uploads_and_can_be_verified) {
  const Job job = finish_a_job();
  ASSERT_TRUE(clouds_->add(store("a stored cloud"), "me").ok());
  const std::string upload = begin_an_upload();
  const auto made = back_up(data(), copy());
  ASSERT_TRUE(made.ok()) << made.error().detail;
  EXPECT_EQ(made->jobs, 1U);
  EXPECT_EQ(made->clouds, 1U);
  EXPECT_EQ(made->uploads, 1U);
  EXPECT_EQ(made->files, 5U) << "two inputs, two outputs, one upload";
  const auto verified = verify_backup(copy());
  ASSERT_TRUE(verified.ok()) << verified.error().detail;
  EXPECT_EQ(verified->bytes, made->bytes);
  const auto restored = UploadStore::open(copy(), {std::chrono::hours(1)}).value();
  EXPECT_EQ(restored->begin(upload).value().upload().offset, 4U) << "it goes on in the copy";
}

TEST_F(BackupTest, what_is_removed_while_a_backup_is_made_is_in_it_and_goes_afterwards) {
  const Job job = finish_a_job();
  OrphanSweep orphans(*jobs_, *artifacts_);
  {
    const auto lease = BackupLease::take(data()).value();
    artifacts_->remove(jobs_->dismiss(job.id).value().garbage);
    EXPECT_EQ(orphans.look().value(), 0U);
    ASSERT_TRUE(orphans.look().ok());
    ASSERT_TRUE(artifacts_->sweep(jobs_->kept().value()).ok());
    EXPECT_TRUE(std::filesystem::exists(data() / mesh_of(job)));
    EXPECT_TRUE(std::filesystem::exists(data() / "inputs" / job.id));
  }
  ASSERT_TRUE(orphans.look().ok());
  ASSERT_TRUE(orphans.look().ok());
  EXPECT_FALSE(std::filesystem::exists(data() / mesh_of(job)));
  EXPECT_FALSE(std::filesystem::exists(data() / "inputs" / job.id));
}

TEST_F(BackupTest, backups_that_are_made_while_everything_is_removed_are_whole) {
  std::atomic<bool> done = false;
  std::thread service([&] {
    std::vector<Job> kept;
    while (!done) {
      kept.push_back(finish_a_job());
      if (kept.size() > 5) {
        artifacts_->remove(jobs_->dismiss(kept.front().id).value().garbage);
        kept.erase(kept.begin());
      }
      const std::string upload = begin_an_upload();
      EXPECT_TRUE(uploads_->begin(upload).value().remove().ok());
      uploads_->sweep();
    }
  });
  for (int i = 0; i < 12; ++i) {
    const auto target = directory_.path() / ("copy" + std::to_string(i));
    const auto made = back_up(data(), target);
    EXPECT_TRUE(made.ok()) << made.error().detail;
    const auto verified = verify_backup(target);
    EXPECT_TRUE(verified.ok()) << verified.error().detail;
  }
  done = true;
  service.join();
}

TEST_F(BackupTest, a_target_that_cannot_hold_a_backup_is_named_and_nothing_is_written) {
  finish_a_job();
  const auto here = directory_.path();
  std::ofstream(here / "empty file").close();
  std::ofstream(here / "file") << "x";
  std::filesystem::create_directory(here / "full");
  std::ofstream(here / "full/x") << "x";
  std::filesystem::create_symlink(here / "none", here / "dangling");
  std::filesystem::create_symlink(data(), here / "other name");
  const auto count = [&] {
    const std::filesystem::recursive_directory_iterator all(here);
    return std::distance(begin(all), end(all));
  };
  const auto before = count();
  for (const std::filesystem::path& target :
       {std::filesystem::path(), here / "empty file", here / "file", here / "file/x", here / "full", here / "dangling",
        data(), data() / "copy", data() / "inputs", data() / "none/copy", data() / "../data/copy",
        here / "other name/copy", here / std::string(300, 'a'), std::filesystem::path("/proc/none"),
        std::filesystem::path("/dev/null")}) {
    const auto made = back_up(data(), target);
    ASSERT_FALSE(made.ok()) << target;
    EXPECT_EQ(made.error().code, ErrorCode::invalid_usage) << target << made.error().detail;
    EXPECT_EQ(made.error().fault->field, "TARGET") << target;
  }
  EXPECT_EQ(count(), before);
  EXPECT_TRUE(back_up(data(), here / "new/folder").ok());
}

TEST_F(BackupTest, a_folder_that_is_no_data_folder_is_named_and_no_target_made) {
  const auto here = directory_.path();
  std::ofstream(here / "file") << "x";
  std::filesystem::create_directory(here / "empty");
  for (const std::filesystem::path& data :
       {here / "none", here / "file", here / "empty", here / std::string(300, 'a')}) {
    const auto made = back_up(data, copy());
    ASSERT_FALSE(made.ok()) << data;
    EXPECT_EQ(made.error().code, ErrorCode::invalid_usage) << data << made.error().detail;
    EXPECT_EQ(made.error().fault->field, "--data") << data;
    EXPECT_THAT(damage(verify_backup(data)), HasSubstr("no finished backup")) << data;
  }
  EXPECT_FALSE(std::filesystem::exists(copy()));
}

TEST_F(BackupTest, a_data_folder_whose_files_are_not_what_its_records_say_makes_no_backup) {
  const Job job = finish_a_job();
  const auto mesh = data() / mesh_of(job);
  std::ofstream(mesh, std::ios::in | std::ios::binary) << "M";
  EXPECT_THAT(damage(back_up(data(), copy())), HasSubstr("mesh.glb has the SHA-256"));
  EXPECT_FALSE(std::filesystem::exists(copy() / "jobs.sqlite")) << "no service starts on it";
  EXPECT_THAT(damage(verify_backup(copy())), HasSubstr("no finished backup"));
  std::filesystem::remove(mesh);
  EXPECT_THAT(damage(back_up(data(), directory_.path() / "second")), HasSubstr("mesh.glb is missing"));
}

TEST_F(BackupTest, verifying_finds_any_file_that_changed_or_went) {
  const Job job = finish_a_job();
  const std::string upload = begin_an_upload();
  const auto changed = [&](const std::filesystem::path& file,
                           const std::function<void(const std::filesystem::path&)>& change) {
    std::filesystem::remove_all(copy());
    EXPECT_TRUE(back_up(data(), copy()).ok());
    change(copy() / file);
    return damage(verify_backup(copy()));
  };
  const auto flip = [](const std::filesystem::path& file) {
    std::ofstream(file, std::ios::in | std::ios::binary) << "!";
  };
  const auto cut = [](const std::filesystem::path& file) { std::filesystem::resize_file(file, 2); };
  const auto remove = [](const std::filesystem::path& file) { std::filesystem::remove(file); };
  const auto input = std::filesystem::path("inputs") / job.id;
  const auto partial = std::filesystem::path("partial") / (upload + ".bytes");
  EXPECT_THAT(changed(input, flip), HasSubstr("has the SHA-256"));
  EXPECT_THAT(changed(mesh_of(job), cut), HasSubstr("has 2 bytes"));
  EXPECT_THAT(changed(mesh_of(job), remove), HasSubstr("is missing"));
  EXPECT_THAT(changed(partial, flip), HasSubstr("is not what was copied"));
  EXPECT_THAT(changed("jobs.sqlite", flip), HasSubstr("jobs.sqlite is not the file that was copied"));
  EXPECT_THAT(changed("store", flip), HasSubstr("'store'"));
  EXPECT_THAT(changed("backup.json", remove), HasSubstr("no finished backup"));
}

TEST_F(BackupTest, a_backup_on_which_a_service_was_started_is_none_any_more) {
  finish_a_job();
  ASSERT_TRUE(back_up(data(), copy()).ok());
  ASSERT_TRUE(end_backup(copy()).ok());
  EXPECT_THAT(damage(verify_backup(copy())), HasSubstr("no finished backup"));
  EXPECT_EQ(back_up(copy() / "none", directory_.path() / "second").error().code, ErrorCode::invalid_usage);
}

}  // namespace
}  // namespace surfaced
