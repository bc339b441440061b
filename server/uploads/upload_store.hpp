// SPDX-License-Identifier: GPL-3.0-or-later
// Uploads that may break off and go on later. Each is a record in the job store's file and a file of its own:
//
//   uploads              the row: length, offset, owner, until when
//   DIR/partial/ID.bytes what has arrived; beyond `offset` it does not count
//
// The row is made before the file, the offset moves after the bytes were synced, and the file goes after the row says
// that the upload is a cloud, or gone. So after a crash at any moment the row tells how much is there for certain, the
// bytes are cut to it before more are appended, and a file without an open row is swept. An upload that was whole but
// no cloud yet becomes one at the next start. A record of an upload that has ended stays for a day, so that its id
// answers "gone".
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "base/unique_fd.hpp"
#include "jobs/job_store.hpp"
#include "platform/clock.hpp"

namespace surfaced {

struct PartialUpload {
  std::string id;
  std::string owner;
  std::uint64_t length = 0;
  /// Bytes that have arrived.
  std::uint64_t offset = 0;
  /// As the client gave it.
  std::string metadata;
  SystemTime created_at;
  SystemTime expires_at;
  /// The stored cloud that it became; empty until it is whole.
  std::string cloud;
  bool gone = false;

  bool whole() const { return offset == length; }
  /// Neither a cloud nor gone: it may go on.
  bool open() const { return cloud.empty() && !gone; }
};

/// upload_not_found.
Error no_such_upload(std::string_view id);

struct UploadLimits {
  /// Of an upload without progress.
  std::chrono::seconds lifetime{std::chrono::hours(24)};
  /// Open at once.
  std::size_t most = 1000;
  /// Of these, of one client; 0 for no limit.
  std::size_t most_of_client = 0;
};

/// Who begins an upload.
struct Uploader {
  std::string owner;
  /// By whom open uploads are counted: a key, or an address; empty for nobody.
  std::string client{};
  Allowance allowance{};
};

class UploadStore {
 public:
  /// @param data  folder of the job store's file, which must have been opened as such before
  static Result<std::unique_ptr<UploadStore>> open(const std::filesystem::path& data, const UploadLimits& limits);
  UploadStore(const UploadStore&) = delete;
  UploadStore& operator=(const UploadStore&) = delete;
  ~UploadStore();

  /// @return  not_ready if as many are open as may be, too_many_requests if they are the client's, quota_exceeded
  Result<PartialUpload> create(const Uploader& uploader, std::uint64_t length, std::string_view metadata);

  /// upload_not_found, upload_gone.
  Result<PartialUpload> find(std::string_view id);

  /// Alone with an upload, for as long as it lives. What is written counts after `keep` alone.
  class Session {
   public:
    Session(Session&& other) noexcept;
    Session& operator=(Session&&) = delete;
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;
    ~Session();

    const PartialUpload& upload() const { return upload_; }
    /// payload_too_large beyond the upload's length.
    Status write(std::span<const std::byte> bytes);
    /// Makes what was written count, durably.
    Result<PartialUpload> keep();
    /// Reads what has arrived, from the beginning.
    Status read(const std::function<Status(std::span<const std::byte>)>& sink) const;
    /// The upload has become this cloud; its bytes are no more needed.
    Status became(const std::string& cloud);
    /// Ends the upload.
    Status remove();

   private:
    friend class UploadStore;
    Session(UploadStore& store, PartialUpload upload, UniqueFd bytes);
    UploadStore* store_;
    PartialUpload upload_;
    UniqueFd bytes_;
    std::uint64_t written_ = 0;
  };
  /// upload_not_found, upload_gone, upload_busy while another session lives.
  Result<Session> begin(std::string_view id);

  /// Ends what has expired and removes every file that no open upload has. Returns how many uploads ended.
  std::size_t sweep();

  /// Ids of uploads that are whole and no cloud yet.
  Result<std::vector<std::string>> whole();

 private:
  struct Records;
  UploadStore(std::filesystem::path data, const UploadLimits& limits, std::unique_ptr<Records> records);
  std::filesystem::path bytes_file(std::string_view id) const { return directory_ / (std::string(id) + ".bytes"); }
  Result<std::optional<PartialUpload>> load(std::string_view id);
  Status save(const PartialUpload& upload);
  Status check_room(const Uploader& uploader) const;
  /// Brings in the records of a version that kept them as files.
  Status import_files();
  /// Takes a session's file, with at least the bytes that its record counts; upload_gone, and it is, if it has lost
  /// some.
  Result<UniqueFd> open_bytes(const PartialUpload& upload);
  void remove_bytes(const std::string& id) const;
  std::size_t end_expired();
  void remove_strays();
  bool take(const std::string& id);
  void release(const std::string& id);

  const std::filesystem::path data_;
  const std::filesystem::path directory_;
  const UploadLimits limits_;
  const std::unique_ptr<Records> records_;
  std::mutex mutex_;
  std::set<std::string> busy_;
};

}  // namespace surfaced
