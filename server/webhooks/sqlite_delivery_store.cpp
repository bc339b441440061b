// SPDX-License-Identifier: GPL-3.0-or-later
#include <mutex>

#include "jobs/sqlite/database.hpp"
#include "jobs/sqlite/errors.hpp"
#include "webhooks/delivery_store.hpp"

namespace surfaced {
namespace {

using namespace sqlite;

constexpr std::chrono::milliseconds kPatience{2'000};
/// So many a call; the next call goes on behind them.
constexpr std::size_t kMostReceivers = 1'000;

Delivery read_delivery(const Query& query) {
  const auto time = [&](int column) {
    return query.null(column) ? std::nullopt : std::optional(from_rfc3339(query.text(column)));
  };
  Delivery delivery{query.text(0),
                    query.text(1),
                    query.text(2),
                    query.text(3),
                    query.text(4),
                    static_cast<std::uint32_t>(query.number(5)),
                    from_rfc3339(query.text(6)),
                    time(7),
                    time(8),
                    static_cast<int>(query.number(9)),
                    query.text(10)};
  if (delivery.status != "pending") delivery.next_at.reset();
  return delivery;
}

class SqliteDeliveryStore final : public DeliveryStore {
 public:
  explicit SqliteDeliveryStore(const std::filesystem::path& file) : database_(file, kPatience) {}

  Result<std::vector<Delivery>> due(std::size_t most, const Wanted& wanted) override {
    return guarded([&]() -> Result<std::vector<Delivery>> {
      const std::scoped_lock lock(mutex_);
      const std::string time = to_rfc3339(now());
      const std::string from = last_;
      bool around = false;
      std::vector<Delivery> found;
      for (std::size_t i = 0; i < kMostReceivers && found.size() < most; ++i) {
        std::optional<std::string> receiver = receiver_after(last_);
        if (!receiver && !around && !last_.empty()) {
          around = true;
          receiver = receiver_after("");
        }
        if (!receiver || (around && *receiver > from)) break;
        last_ = std::move(*receiver);
        if (!wanted(last_)) continue;
        if (auto delivery = oldest_of(last_, time)) found.push_back(std::move(*delivery));
      }
      return found;
    });
  }

  Status tried(const Delivery& delivery) override {
    return guarded([&]() -> Status {
      const std::scoped_lock lock(mutex_);
      const std::string next = to_rfc3339(delivery.next_at.value_or(delivery.created_at));
      const std::string tried = to_rfc3339(delivery.tried_at.value_or(now()));
      Transaction transaction(database_, Transaction::Kind::write);
      Query(database_,
            "UPDATE deliveries SET status = ?, attempts = ?, next_at = ?, tried_at = ?, http_status = ?, detail = ? "
            "WHERE id = ?")
          .bind(delivery.status)
          .bind(std::int64_t{delivery.attempts})
          .bind(next)
          .bind(tried)
          .bind(std::int64_t{delivery.http_status})
          .bind(delivery.detail)
          .bind(delivery.id)
          .run();
      transaction.commit();
      return Done{};
    });
  }

  Result<std::vector<Delivery>> of_job(std::string_view job) override {
    return guarded([&]() -> Result<std::vector<Delivery>> {
      const std::scoped_lock lock(mutex_);
      Query query(database_,
                  "SELECT id, job, url, receiver, status, attempts, created_at, next_at, tried_at, http_status, detail "
                  "FROM deliveries WHERE job = ? ORDER BY seq");
      query.bind(job);
      return all(query);
    });
  }

 private:
  /// The next one, by name, for which anything is pending.
  std::optional<std::string> receiver_after(std::string_view name) {
    Query query(database_,
                "SELECT receiver FROM deliveries WHERE status = 'pending' AND receiver > ? ORDER BY receiver LIMIT 1");
    query.bind(name);
    return query.step() ? std::optional(query.text(0)) : std::nullopt;
  }

  std::optional<Delivery> oldest_of(std::string_view receiver, std::string_view time) {
    Query query(database_,
                "SELECT id, job, url, receiver, status, attempts, created_at, next_at, tried_at, http_status, detail "
                "FROM deliveries WHERE status = 'pending' AND receiver = ? AND next_at <= ? ORDER BY next_at LIMIT 1");
    query.bind(receiver).bind(time);
    return query.step() ? std::optional(read_delivery(query)) : std::nullopt;
  }

  static std::vector<Delivery> all(Query& query) {
    std::vector<Delivery> found;
    while (query.step()) found.push_back(read_delivery(query));
    return found;
  }

  std::mutex mutex_;
  Database database_;
  /// The receiver that was asked for last.
  std::string last_;
};

}  // namespace

Result<std::unique_ptr<DeliveryStore>> open_sqlite_delivery_store(const std::filesystem::path& file) {
  return guarded([&]() -> Result<std::unique_ptr<DeliveryStore>> {
    return std::unique_ptr<DeliveryStore>(std::make_unique<SqliteDeliveryStore>(file));
  });
}

}  // namespace surfaced
