// SPDX-License-Identifier: GPL-3.0-or-later
#include "clouds/cloud_service.hpp"

namespace surfaced {

Result<CloudStore::Added> CloudService::add(Upload& upload, std::string_view owner, const Allowance& allowance) {
  if (upload.bytes() == 0) return Error{ErrorCode::empty_input, "the cloud has 0 bytes"};
  const std::scoped_lock lock(mutex_);
  const std::string id = upload.sha256();
  // A child that may read nothing but the file that is there now must not lose it to another one with the same bytes.
  // A record alone is not trusted: its bytes may have been lost outside of the service.
  const bool known = clouds_.find(id, std::nullopt).ok();
  if (!known || !artifacts_.has_input(id, upload.bytes())) {
    if (const auto input = upload.commit(id); !input) return input.error();
  }
  auto added = clouds_.add({id, upload.bytes(), id}, owner, allowance);
  if (!added && !known && added.error().code == ErrorCode::quota_exceeded) artifacts_.remove({{id}, {}});
  if (added && added->cloud.status == CloudStatus::inspecting) inspector_.wake();
  return added;
}

Status CloudService::remove(std::string_view id, std::optional<std::string_view> owner) {
  const std::scoped_lock lock(mutex_);
  const auto last = clouds_.remove(id, owner);
  if (!last) return last.error();
  if (*last) artifacts_.remove({{std::string(id)}, {}});
  return Done{};
}

Result<std::size_t> CloudService::expire(std::chrono::seconds unused) {
  const std::scoped_lock lock(mutex_);
  auto gone = clouds_.expire(unused);
  if (!gone) return gone.error();
  const std::size_t count = gone->size();
  artifacts_.remove({std::move(*gone), {}});
  return count;
}

}  // namespace surfaced
