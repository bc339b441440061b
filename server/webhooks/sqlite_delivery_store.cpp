// SPDX-License-Identifier: GPL-3.0-or-later
#include <mutex>

#include "jobs/sqlite/database.hpp"
#include "jobs/sqlite/errors.hpp"
#include "webhooks/delivery_store.hpp"

namespace surfaced {
namespace {

using namespace sqlite;

constexpr std::chrono::milliseconds kPatience{2'000};
constexpr int kUrlColumn = 2;

Delivery read_delivery(const Query& query) {
  const auto time = [&](int column) {
    return query.null(column) ? std::nullopt : std::optional(from_rfc3339(query.text(column)));
  };
  Delivery delivery{query.text(0),
                    query.text(1),
                    query.text(kUrlColumn),
                    query.text(3),
                    static_cast<std::uint32_t>(query.number(4)),
                    from_rfc3339(query.text(5)),
                    time(6),
                    time(7),
                    static_cast<int>(query.number(8)),
                    query.text(9)};
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
      Query query(database_,
                  "SELECT id, job, url, status, attempts, created_at, next_at, tried_at, http_status, detail "
                  "FROM deliveries WHERE status = 'pending' AND next_at <= ? ORDER BY next_at");
      query.bind(time);
      std::vector<Delivery> found;
      while (found.size() < most && query.step()) {
        if (wanted(query.text(kUrlColumn))) found.push_back(read_delivery(query));
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
                  "SELECT id, job, url, status, attempts, created_at, next_at, tried_at, http_status, detail "
                  "FROM deliveries WHERE job = ? ORDER BY seq");
      query.bind(job);
      return all(query);
    });
  }

 private:
  static std::vector<Delivery> all(Query& query) {
    std::vector<Delivery> found;
    while (query.step()) found.push_back(read_delivery(query));
    return found;
  }

  std::mutex mutex_;
  Database database_;
};

}  // namespace

Result<std::unique_ptr<DeliveryStore>> open_sqlite_delivery_store(const std::filesystem::path& file) {
  return guarded([&]() -> Result<std::unique_ptr<DeliveryStore>> {
    return std::unique_ptr<DeliveryStore>(std::make_unique<SqliteDeliveryStore>(file));
  });
}

}  // namespace surfaced
