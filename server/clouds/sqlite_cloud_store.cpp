// SPDX-License-Identifier: GPL-3.0-or-later
#include <mutex>

#include "clouds/cloud_store.hpp"
#include "jobs/sqlite/database.hpp"
#include "jobs/sqlite/errors.hpp"
#include "jobs/sqlite/holding_rows.hpp"

namespace surfaced {
namespace {

using namespace sqlite;
using Json = nlohmann::ordered_json;

constexpr std::chrono::milliseconds kDatabasePatience{2'000};

CloudStatus status_named(const std::string& name) {
  if (name == "ready") return CloudStatus::ready;
  return name == "refused" ? CloudStatus::refused : CloudStatus::inspecting;
}

std::optional<Cloud> select_cloud(Database& database, std::string_view id) {
  Query query(
      database,
      "SELECT id, bytes, status, created_at, facts, error_code, error_detail, used_at FROM clouds WHERE id = ?");
  query.bind(id);
  if (!query.step()) return std::nullopt;
  Cloud cloud{query.text(0),
              static_cast<std::uint64_t>(query.number(1)),
              status_named(query.text(2)),
              from_rfc3339(query.text(3)),
              from_rfc3339(query.text(7)),
              {},
              {}};
  if (!query.null(4)) cloud.facts = Json::parse(query.text(4), nullptr, false);
  if (!query.null(5)) {
    ErrorCode code = ErrorCode::internal_error;
    error_code_named(query.text(5), code);
    cloud.error = Error{code, query.text(6)};
  }
  return cloud;
}

bool holds(Database& database, std::string_view id, std::string_view owner) {
  Query query(database, "SELECT 1 FROM cloud_holders WHERE cloud = ? AND owner = ?");
  query.bind(id).bind(owner);
  return query.step();
}

std::optional<std::string> job_with(Database& database, std::string_view id) {
  Query query(database, "SELECT id FROM jobs WHERE input_key = ? AND removed_at IS NULL LIMIT 1");
  query.bind(id);
  return query.step() ? std::optional(query.text(0)) : std::nullopt;
}

std::optional<std::string> job_of(Database& database, std::string_view id, std::string_view owner) {
  Query query(database, "SELECT id FROM jobs WHERE input_key = ? AND owner = ? AND removed_at IS NULL LIMIT 1");
  query.bind(id).bind(owner);
  return query.step() ? std::optional(query.text(0)) : std::nullopt;
}

Error unknown_cloud(std::string_view id) {
  std::string text(id.substr(0, 64));
  return with_fault({ErrorCode::cloud_not_found, "no cloud has the id '" + text + "'"},
                    {"cloud_id", text, "the SHA-256 of a cloud that POST /v1/clouds has taken"});
}

class SqliteCloudStore final : public CloudStore {
 public:
  explicit SqliteCloudStore(const std::filesystem::path& file) : database_(file, kDatabasePatience) {}

  Result<Added> add(const StoredInput& input, std::string_view owner, const Allowance& allowance) override {
    return locked([&]() -> Result<Added> {
      const std::string created = to_rfc3339(now());
      Transaction transaction(database_, Transaction::Kind::write);
      const bool had = holds(database_, input.sha256, owner);
      if (Status may = admit(database_, owner, allowance, {0, had ? 0 : input.bytes}); !had && !may.ok()) {
        return may.error();
      }
      Query(database_,
            "INSERT INTO clouds (id, bytes, status, created_at, used_at) VALUES (?1, ?2, 'inspecting', ?3, ?3) "
            "ON CONFLICT (id) DO UPDATE SET used_at = excluded.used_at")
          .bind(input.sha256)
          .bind(static_cast<std::int64_t>(input.bytes))
          .bind(created)
          .run();
      if (!had) {
        Query(database_, "INSERT INTO cloud_holders (cloud, owner) VALUES (?, ?)").bind(input.sha256).bind(owner).run();
      }
      Added added{*select_cloud(database_, input.sha256), !had};
      transaction.commit();
      return added;
    });
  }

  Result<Cloud> find(std::string_view id, std::optional<std::string_view> owner) override {
    return locked([&]() -> Result<Cloud> {
      const Transaction transaction(database_, Transaction::Kind::read);
      auto cloud = select_cloud(database_, id);
      if (!cloud || (owner && !holds(database_, id, *owner))) return unknown_cloud(id);
      return std::move(*cloud);
    });
  }

  Result<bool> remove(std::string_view id, std::optional<std::string_view> owner) override {
    return locked([&]() -> Result<bool> {
      Transaction transaction(database_, Transaction::Kind::write);
      if (!select_cloud(database_, id) || (owner && !holds(database_, id, *owner))) return unknown_cloud(id);
      const auto job = owner ? job_of(database_, id, *owner) : job_with(database_, id);
      if (job) return in_use(id, *job);
      if (owner) {
        Query(database_, "DELETE FROM cloud_holders WHERE cloud = ? AND owner = ?").bind(id).bind(*owner).run();
      } else {
        Query(database_, "DELETE FROM cloud_holders WHERE cloud = ?").bind(id).run();
      }
      const bool last = !has_holder(id);
      // Jobs of an administrator may use a cloud that is not his.
      if (last) {
        if (const auto other = job_with(database_, id)) return in_use(id, *other);
        Query(database_, "DELETE FROM clouds WHERE id = ?").bind(id).run();
      }
      transaction.commit();
      return last;
    });
  }

  Result<std::vector<std::string>> expire(std::chrono::seconds unused) override {
    return locked([&]() -> Result<std::vector<std::string>> {
      const std::string limit = to_rfc3339(now() - unused);
      Transaction transaction(database_, Transaction::Kind::write);
      std::vector<std::string> ids;
      {
        Query query(database_,
                    "SELECT id FROM clouds WHERE used_at <= ? AND NOT EXISTS "
                    "(SELECT 1 FROM jobs WHERE input_key = clouds.id AND removed_at IS NULL) LIMIT 1000");
        query.bind(limit);
        while (query.step()) ids.push_back(query.text(0));
      }
      for (const std::string& id : ids) Query(database_, "DELETE FROM clouds WHERE id = ?").bind(id).run();
      transaction.commit();
      return ids;
    });
  }

  Result<std::optional<std::string>> next_to_inspect() override {
    return locked([&]() -> Result<std::optional<std::string>> {
      Query query(database_, "SELECT id FROM clouds WHERE status = 'inspecting' ORDER BY created_at LIMIT 1");
      return query.step() ? std::optional(query.text(0)) : std::optional<std::string>();
    });
  }

  Status inspected(std::string_view id, const Result<Json>& facts) override {
    return locked([&]() -> Status {
      const std::string text = facts ? facts->dump() : "";
      Transaction transaction(database_, Transaction::Kind::write);
      if (facts) {
        Query(database_, "UPDATE clouds SET status = 'ready', facts = ? WHERE id = ?").bind(text).bind(id).run();
      } else {
        Query(database_, "UPDATE clouds SET status = 'refused', error_code = ?, error_detail = ? WHERE id = ?")
            .bind(name_of(facts.error().code))
            .bind(facts.error().detail)
            .bind(id)
            .run();
      }
      transaction.commit();
      return Done{};
    });
  }

  Result<std::vector<std::string>> kept() override {
    return locked([&]() -> Result<std::vector<std::string>> {
      std::vector<std::string> ids;
      Query query(database_, "SELECT id FROM clouds");
      while (query.step()) ids.push_back(query.text(0));
      return ids;
    });
  }

 private:
  static Error in_use(std::string_view id, const std::string& job) {
    return {ErrorCode::cloud_in_use, "the cloud '" + std::string(id) + "' is used by the job " + job};
  }

  bool has_holder(std::string_view id) {
    Query query(database_, "SELECT 1 FROM cloud_holders WHERE cloud = ? LIMIT 1");
    query.bind(id);
    return query.step();
  }

  template <class Work>
  auto locked(const Work& work) -> decltype(work()) {
    return guarded([&] {
      const std::scoped_lock lock(mutex_);
      return work();
    });
  }

  std::mutex mutex_;
  Database database_;
};

}  // namespace

std::string_view name_of(CloudStatus status) {
  switch (status) {
    case CloudStatus::ready:
      return "ready";
    case CloudStatus::refused:
      return "refused";
    default:
      return "inspecting";
  }
}

Result<std::unique_ptr<CloudStore>> open_sqlite_cloud_store(const std::filesystem::path& file) {
  return guarded([&]() -> Result<std::unique_ptr<CloudStore>> {
    return std::unique_ptr<CloudStore>(std::make_unique<SqliteCloudStore>(file));
  });
}

}  // namespace surfaced
