// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "artifacts/artifact_store.hpp"
#include "clouds/cloud_service.hpp"
#include "uploads/upload_store.hpp"

namespace surfaced {

/// Makes stored clouds of uploads that are whole: at once for who sent the last byte, and in a thread of its own for
/// those whose server died between the last byte and the cloud, or had no space for it.
class UploadFinishing {
 public:
  UploadFinishing(UploadStore& uploads, ArtifactStore& artifacts, CloudService& clouds)
      : uploads_(uploads), artifacts_(artifacts), clouds_(clouds) {}
  ~UploadFinishing() { stop(); }
  UploadFinishing(const UploadFinishing&) = delete;
  UploadFinishing& operator=(const UploadFinishing&) = delete;

  UploadStore& store() { return uploads_; }

  /// Safe to be called again after any failure or crash: the cloud has the name of its bytes.
  /// @param session  of an upload that is whole
  Result<PartialUpload> finish(UploadStore::Session& session);

  void start();
  /// To be called now and then: what could not be finished before is tried again.
  void wake();
  void stop();

 private:
  void work();
  void finish_all();
  void finish_one(const std::string& id);
  bool stopping();

  UploadStore& uploads_;
  ArtifactStore& artifacts_;
  CloudService& clouds_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool woken_ = true;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace surfaced
