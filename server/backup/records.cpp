// SPDX-License-Identifier: GPL-3.0-or-later
#include "backup/records.hpp"

#include "jobs/sqlite/database.hpp"
#include "jobs/sqlite/holding_rows.hpp"
#include "jobs/sqlite/job_rows.hpp"
#include "jobs/sqlite/schema.hpp"

namespace surfaced {
namespace {

using sqlite::Database;
using sqlite::Query;

constexpr std::chrono::milliseconds kPatience{10'000};

std::uint64_t count(Database& database, const char* sql) {
  Query query(database, sql);
  return query.step() ? static_cast<std::uint64_t>(query.number(0)) : 0;
}

void add_inputs(Database& database, std::vector<RecordedFile>& files) {
  Query query(database,
              "SELECT input_key, input_bytes, input_sha256 FROM jobs WHERE removed_at IS NULL "
              "UNION SELECT id, bytes, id FROM clouds");
  while (query.step()) {
    files.push_back(
        {std::filesystem::path("inputs") / query.text(0), static_cast<std::uint64_t>(query.number(1)), query.text(2)});
  }
}

void add_outputs(Database& database, std::vector<RecordedFile>& files) {
  Query query(database, "SELECT job || '-' || attempt, name, bytes, sha256 FROM outputs ORDER BY job, attempt, name");
  while (query.step()) {
    files.push_back({std::filesystem::path("outputs") / query.text(0) / query.text(1),
                     static_cast<std::uint64_t>(query.number(2)), query.text(3)});
  }
}

void add_uploads(Database& database, std::vector<RecordedFile>& files) {
  Query query(database, "SELECT id, offset FROM uploads WHERE cloud = '' AND gone = 0 AND offset > 0");
  while (query.step()) {
    files.push_back({std::filesystem::path("partial") / (query.text(0) + ".bytes"),
                     static_cast<std::uint64_t>(query.number(1)), ""});
  }
}

template <class Work>
auto reading(const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const sqlite::SqliteError& error) {
    return Error{ErrorCode::input_unreadable, error.what()};
  }
}

}  // namespace

Status copy_records(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (!std::filesystem::exists(from)) {
    return Error{ErrorCode::invalid_usage, "there is no job store at '" + from.string() + "'"};
  }
  try {
    Database database(from, kPatience);
    if (const auto version = sqlite::version_of(database); version != sqlite::newest_version()) {
      return Error{ErrorCode::invalid_usage,
                   "the job store has version " + std::to_string(version) + ", this surfaced copies version " +
                       std::to_string(sqlite::newest_version()) + "; use the surfaced that serves it"};
    }
    const std::string target = to.string();
    Query(database, "VACUUM INTO ?").bind(target).run();
    return Done{};
  } catch (const sqlite::SqliteError& error) {
    return Error{ErrorCode::output_not_writable, error.what()};
  }
}

Result<Recorded> read_records(const std::filesystem::path& copy) {
  return reading([&]() -> Result<Recorded> {
    Database database = Database::unchanging(copy);
    Recorded recorded;
    recorded.store = sqlite::select_identity(database);
    recorded.jobs = count(database, "SELECT count(*) FROM jobs WHERE removed_at IS NULL");
    recorded.clouds = count(database, "SELECT count(*) FROM clouds");
    recorded.uploads = count(database, "SELECT count(*) FROM uploads WHERE cloud = '' AND gone = 0");
    add_inputs(database, recorded.files);
    add_outputs(database, recorded.files);
    add_uploads(database, recorded.files);
    return recorded;
  });
}

Result<std::vector<std::string>> check_records(const std::filesystem::path& copy) {
  return reading([&]() -> Result<std::vector<std::string>> {
    Database database = Database::unchanging(copy);
    std::vector<std::string> wrong;
    for (const char* check : {"PRAGMA integrity_check", "PRAGMA foreign_key_check"}) {
      Query query(database, check);
      while (query.step()) {
        if (query.text(0) != "ok") wrong.push_back("jobs.sqlite: " + query.text(0));
      }
    }
    if (const auto owners = sqlite::count_wrong_holdings(database); owners > 0) {
      wrong.push_back("jobs.sqlite: what " + std::to_string(owners) + " keys hold is counted wrong");
    }
    return wrong;
  });
}

}  // namespace surfaced
