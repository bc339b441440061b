// SPDX-License-Identifier: GPL-3.0-or-later
#include "uploads/finishing.hpp"

#include "observability/log.hpp"
#include "observability/survives.hpp"

namespace surfaced {

Result<PartialUpload> UploadFinishing::finish(UploadStore::Session& session) {
  if (!session.upload().cloud.empty()) return session.upload();
  if (Status space = artifacts_.check_space(session.upload().length); !space.ok()) return space.error();
  const auto place = artifacts_.begin_upload();
  if (!place) return place.error();
  const Status copied = session.read([&](std::span<const std::byte> bytes) { return (*place)->write(bytes); });
  if (!copied) return copied.error();
  // Without an allowance: its bytes were counted when the upload was created.
  const auto added = clouds_.add(**place, session.upload().owner);
  if (!added) return added.error();
  if (Status noted = session.became(added->cloud.id); !noted.ok()) return noted.error();
  return session.upload();
}

void UploadFinishing::start() {
  thread_ = std::thread([this] { work(); });
}

void UploadFinishing::wake() {
  const std::scoped_lock lock(mutex_);
  woken_ = true;
  wake_.notify_all();
}

void UploadFinishing::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
    wake_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

bool UploadFinishing::stopping() {
  const std::scoped_lock lock(mutex_);
  return stopping_;
}

void UploadFinishing::work() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stopping_ || woken_; });
      if (stopping_) return;
      woken_ = false;
    }
    survives("look for uploads that are whole", [this] { finish_all(); });
  }
}

void UploadFinishing::finish_all() {
  const auto ids = uploads_.whole();
  if (!ids) {
    log(LogLevel::error, "cannot look for uploads that are whole", {{"detail", ids.error().detail}});
    return;
  }
  for (const std::string& id : *ids) {
    if (stopping()) return;
    survives("finish an upload", [&] { finish_one(id); });
  }
}

void UploadFinishing::finish_one(const std::string& id) {
  auto session = uploads_.begin(id);
  // The request that sent the last byte is at it.
  if (!session && session.error().code == ErrorCode::upload_busy) return;
  const auto finished = session ? finish(*session) : Result<PartialUpload>(session.error());
  if (finished) return;
  log(LogLevel::error, "cannot finish an upload", {{"upload", id}, {"detail", finished.error().detail}});
}

}  // namespace surfaced
