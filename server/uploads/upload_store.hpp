// SPDX-License-Identifier: GPL-3.0-or-later
// Uploads that may break off and go on later. Each is two files under one directory:
//
//   DIR/ID.bytes   what has arrived; beyond `offset` it does not count
//   DIR/ID.json    the record: length, offset, owner, until when; replaced as a whole after the bytes were synced
//
// After a crash at any moment the record tells how much is there for certain, and the bytes are cut to it before
// more are appended. A record whose upload was ended or has expired stays for a day, so that its id answers "gone".
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "base/base.hpp"
#include "platform/clock.hpp"
#include "platform/unique_fd.hpp"

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
};

/// upload_not_found.
Error no_such_upload(std::string_view id);

class UploadStore {
 public:
  /// @param lifetime  of an upload without progress
  static Result<std::unique_ptr<UploadStore>> open(const std::filesystem::path& directory,
                                                   std::chrono::seconds lifetime);

  Result<PartialUpload> create(std::string_view owner, std::uint64_t length, std::string_view metadata);

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

  /// Drops what has expired. Returns how many uploads.
  std::size_t expire();

  /// Bytes that the owner's uploads hold or may still come to hold.
  std::uint64_t promised_to(std::string_view owner);

 private:
  UploadStore(std::filesystem::path directory, std::chrono::seconds lifetime)
      : directory_(std::move(directory)), lifetime_(lifetime) {}
  std::filesystem::path bytes_file(std::string_view id) const { return directory_ / (std::string(id) + ".bytes"); }
  std::filesystem::path record_file(std::string_view id) const { return directory_ / (std::string(id) + ".json"); }
  Result<PartialUpload> load(std::string_view id) const;
  Status save(const PartialUpload& upload) const;
  bool take(const std::string& id);
  void release(const std::string& id);

  const std::filesystem::path directory_;
  const std::chrono::seconds lifetime_;
  std::mutex mutex_;
  std::set<std::string> busy_;
};

}  // namespace surfaced
