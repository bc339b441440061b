// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "jobs/job.hpp"
#include "jobs/job_store.hpp"

namespace surfaced {

/// What is known of a stored cloud.
enum class CloudStatus : std::uint8_t {
  /// No child has read it yet.
  inspecting,
  ready,
  /// A child has read it and refused it; a job on it would fail with the same error.
  refused,
};
std::string_view name_of(CloudStatus status);

/// A cloud that is stored once, whoever sent it how often; its id is the SHA-256 of its bytes.
// NOLINTNEXTLINE(bugprone-exception-escape)
struct Cloud {
  std::string id;
  std::uint64_t bytes = 0;
  CloudStatus status = CloudStatus::inspecting;
  SystemTime created_at;
  /// When somebody last sent it, or named it in a job.
  SystemTime used_at;
  /// What the child found: points, bounds, attributes. Null unless ready.
  nlohmann::ordered_json facts;
  std::optional<Error> error;
};

/// Where the records of stored clouds are kept, in the file of the job store. A cloud belongs to all who sent it,
/// and is gone when the last of them has deleted it. All calls are safe in threads; errors as of JobStore.
class CloudStore {
 public:
  CloudStore() = default;
  CloudStore(const CloudStore&) = delete;
  CloudStore& operator=(const CloudStore&) = delete;
  virtual ~CloudStore() = default;

  struct Added {
    Cloud cloud;
    /// False if the owner had sent it before.
    bool created = false;
  };
  /// @param allowance  of the owner; quota_exceeded if he may not have it. What he had before he has still.
  virtual Result<Added> add(const StoredInput& input, std::string_view owner, const Allowance& allowance) = 0;
  Result<Added> add(const StoredInput& input, std::string_view owner) { return add(input, owner, {}); }

  /// @param owner  none for any; else cloud_not_found unless the cloud is his
  virtual Result<Cloud> find(std::string_view id, std::optional<std::string_view> owner) = 0;

  /// @return true if the cloud's file is to be removed; cloud_not_found, or cloud_in_use naming a job of his (the
  ///         last owner: of anybody) that was not removed.
  virtual Result<bool> remove(std::string_view id, std::optional<std::string_view> owner) = 0;

  /// Removes the clouds that no job refers to and that nobody has sent or named in a job for this long.
  /// @return their ids, a bounded number; their files are to be removed.
  virtual Result<std::vector<std::string>> expire(std::chrono::seconds unused) = 0;

  /// A cloud that no child has read yet.
  virtual Result<std::optional<std::string>> next_to_inspect() = 0;
  virtual Status inspected(std::string_view id, const Result<nlohmann::ordered_json>& facts) = 0;

  /// Ids of all.
  virtual Result<std::vector<std::string>> kept() = 0;
};

/// Opens the records in the job store's file, which must have been opened as such before.
Result<std::unique_ptr<CloudStore>> open_sqlite_cloud_store(const std::filesystem::path& file);

}  // namespace surfaced
