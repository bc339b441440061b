// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "artifacts/artifact_store.hpp"
#include "clouds/cloud_store.hpp"
#include "clouds/inspector.hpp"

namespace surfaced {

/// What the endpoints of the service do with stored clouds: the file and its record come and go together.
class CloudService {
 public:
  CloudService(CloudStore& clouds, ArtifactStore& artifacts, CloudInspector& inspector)
      : clouds_(clouds), artifacts_(artifacts), inspector_(inspector) {}

  /// @param allowance  of the owner; quota_exceeded
  Result<CloudStore::Added> add(Upload& upload, std::string_view owner, const Allowance& allowance = {});

  Result<Cloud> find(std::string_view id, std::optional<std::string_view> owner) { return clouds_.find(id, owner); }

  Status remove(std::string_view id, std::optional<std::string_view> owner);

  /// Removes clouds that nobody has sent and no job has used for this long; returns how many.
  Result<std::size_t> expire(std::chrono::seconds unused);

 private:
  CloudStore& clouds_;
  ArtifactStore& artifacts_;
  CloudInspector& inspector_;
  // Between a file and its record nobody may change either.
  std::mutex mutex_;
};

}  // namespace surfaced
