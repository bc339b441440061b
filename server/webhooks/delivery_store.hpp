// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "platform/clock.hpp"

namespace surfaced {

/// A job's end that somebody is to be told of. It is written in the transaction that ends the job (a trigger of the job
/// store), so that none is lost and none is told of what did not happen; it is told at least once.
struct Delivery {
  std::string id;
  std::string job;
  std::string url;
  /// Host and port of the URL, in lower case, which all its deliveries have in common.
  std::string receiver;
  /// pending, delivered or given_up.
  std::string status;
  std::uint32_t attempts = 0;
  SystemTime created_at;
  std::optional<SystemTime> next_at;
  std::optional<SystemTime> tried_at;
  /// What the receiver answered last; 0 if it did not.
  int http_status = 0;
  /// What went wrong last.
  std::string detail;
};

/// The outbox and the log of deliveries, in the file of the job store. Safe in threads; errors as of JobStore.
class DeliveryStore {
 public:
  DeliveryStore() = default;
  DeliveryStore(const DeliveryStore&) = delete;
  DeliveryStore& operator=(const DeliveryStore&) = delete;
  virtual ~DeliveryStore() = default;

  /// Tells whether a delivery to this receiver is wanted now.
  using Wanted = std::function<bool(const std::string& receiver)>;
  /// Pending ones whose time has come, of each receiver that is wanted the oldest: receivers in turn, from the one
  /// after that where the last call ended.
  /// @cost  a search for each receiver up to a limit, however many wait for it
  virtual Result<std::vector<Delivery>> due(std::size_t most, const Wanted& wanted) = 0;

  /// What became of an attempt: delivered, or to be tried again at `next_at`, or given up without one.
  virtual Status tried(const Delivery& delivery) = 0;

  virtual Result<std::vector<Delivery>> of_job(std::string_view job) = 0;
};

Result<std::unique_ptr<DeliveryStore>> open_sqlite_delivery_store(const std::filesystem::path& file);

}  // namespace surfaced
