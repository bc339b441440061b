// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/sqlite_backup.hpp"

#include "jobs/sqlite/database.hpp"
#include "jobs/sqlite/job_rows.hpp"

namespace surfaced {
namespace {

constexpr std::chrono::milliseconds kPatience{10'000};

}  // namespace

Result<Artifacts> copy_job_store(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (!std::filesystem::exists(from)) {
    return Error{ErrorCode::invalid_usage, "there is no job store at '" + from.string() + "'"};
  }
  try {
    {
      sqlite::Database database(from, kPatience);
      const std::string target = to.string();
      sqlite::Query(database, "VACUUM INTO ?").bind(target).run();
    }
    sqlite::Database copy(to, kPatience);
    return Artifacts{sqlite::select_inputs(copy), sqlite::select_published(copy)};
  } catch (const sqlite::SqliteError& error) {
    return Error{ErrorCode::output_not_writable, error.what()};
  }
}

Status forget_jobs(const std::filesystem::path& copy, const std::vector<std::string>& ids) {
  try {
    sqlite::Database database(copy, kPatience);
    sqlite::Transaction transaction(database, sqlite::Transaction::Kind::write);
    for (const std::string& id : ids) sqlite::Query(database, "DELETE FROM jobs WHERE id = ?").bind(id).run();
    transaction.commit();
    return Done{};
  } catch (const sqlite::SqliteError& error) {
    return Error{ErrorCode::output_not_writable, error.what()};
  }
}

}  // namespace surfaced
