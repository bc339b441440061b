#include "jobs/sqlite/listing_rows.hpp"

#include <limits>

#include "jobs/sqlite/job_rows.hpp"

namespace surfaced::sqlite {
namespace {

// A view of nothing would be bound as NULL.
constexpr std::string_view kAny = "";

}  // namespace

JobPage select_page(Database& database, const JobFilter& filter, std::size_t limit,
                    std::optional<std::int64_t> before) {
  const std::string labels = nlohmann::json(filter.labels).dump();
  const std::string methods = nlohmann::json(filter.methods).dump();
  nlohmann::json names = nlohmann::json::array();
  for (const JobStatus status : filter.statuses) names.push_back(name_of(status));
  const std::string statuses = names.dump();
  const std::string from = filter.created_from ? to_rfc3339(*filter.created_from) : std::string();
  const std::string to = filter.created_to ? to_rfc3339(*filter.created_to) : std::string();
  const std::string time = to_rfc3339(now());
  std::vector<std::pair<std::string, std::int64_t>> found;
  {
    Query query(database,
                "SELECT id, seq FROM jobs WHERE removed_at IS NULL AND seq < ?1 AND (?2 OR owner = ?3) "
                "AND (?4 = '[]' OR status IN (SELECT value FROM json_each(?4))) "
                "AND (?5 = '[]' OR method IN (SELECT value FROM json_each(?5))) "
                "AND NOT EXISTS (SELECT 1 FROM json_each(?6) AS asked "
                "WHERE asked.value NOT IN (SELECT value FROM json_each(jobs.labels))) "
                "AND created_at >= ?7 AND (?8 = '' OR created_at <= ?8) "
                "AND (?9 < 0 OR (julianday(coalesce(finished_at, ?11)) - julianday(started_at)) * 86400 >= ?9) "
                "AND (?10 < 0 OR (julianday(coalesce(finished_at, ?11)) - julianday(started_at)) * 86400 <= ?10) "
                "ORDER BY seq DESC LIMIT ?12");
    query.bind(before.value_or(std::numeric_limits<std::int64_t>::max()));
    query.bind(std::int64_t{!filter.owner}).bind(filter.owner ? std::string_view(*filter.owner) : kAny);
    query.bind(statuses).bind(methods).bind(labels).bind(from).bind(to);
    query.bind(filter.shortest.value_or(-1)).bind(filter.longest.value_or(-1)).bind(time);
    query.bind(static_cast<std::int64_t>(limit + 1));
    while (query.step()) found.emplace_back(query.text(0), query.number(1));
  }
  JobPage page;
  if (found.size() > limit) {
    found.pop_back();
    page.next = found.back().second;
  }
  for (const auto& [id, seq] : found) page.jobs.push_back(std::move(select_job(database, id)->job));
  return page;
}

std::optional<std::string> select_owner(Database& database, std::string_view id) {
  Query query(database, "SELECT owner FROM jobs WHERE id = ?");
  query.bind(id);
  return query.step() ? std::optional(query.text(0)) : std::nullopt;
}

Holding select_holding(Database& database, std::string_view owner) {
  // A stored cloud counts once, however many jobs use it.
  Query query(
      database,
      "SELECT (SELECT count(*) FROM jobs WHERE owner = ?1 AND status IN ('accepted', 'running')), "
      "(SELECT coalesce(sum(input_bytes), 0) FROM jobs WHERE owner = ?1 AND removed_at IS NULL "
      "AND input_key <> input_sha256) + "
      "(SELECT coalesce(sum(o.bytes), 0) FROM outputs o JOIN jobs j ON j.id = o.job WHERE j.owner = ?1) + "
      "(SELECT coalesce(sum(c.bytes), 0) FROM cloud_holders h JOIN clouds c ON c.id = h.cloud WHERE h.owner = ?1)");
  query.bind(owner);
  if (!query.step()) return {};
  return {static_cast<std::uint64_t>(query.number(0)), static_cast<std::uint64_t>(query.number(1))};
}

bool use_cloud(Database& database, std::string_view id, SystemTime time) {
  const std::string used = to_rfc3339(time);
  Query(database, "UPDATE clouds SET used_at = ? WHERE id = ?").bind(used).bind(id).run();
  return database.changes() > 0;
}

void insert_idempotency(Database& database, const NewJob& job) {
  Query(database, "INSERT INTO idempotency (owner, key, fingerprint, job) VALUES (?, ?, ?, ?)")
      .bind(job.owner)
      .bind(job.idempotency_key)
      .bind(job.fingerprint)
      .bind(job.id)
      .run();
}

std::optional<Replay> select_replay(Database& database, std::string_view owner, std::string_view key) {
  Query query(database, "SELECT fingerprint, job FROM idempotency WHERE owner = ? AND key = ?");
  query.bind(owner).bind(key);
  return query.step() ? std::optional(Replay{query.text(0), query.text(1)}) : std::nullopt;
}

bool insert_output(Database& database, const Claim& source, const Output& output) {
  {
    Query query(database,
                "SELECT 1 FROM jobs WHERE id = ? AND attempt = ? AND status = 'successful' AND removed_at IS NULL");
    query.bind(source.job).bind(std::int64_t{source.attempt});
    if (!query.step()) return false;
  }
  Query(database, "INSERT OR REPLACE INTO outputs (job, name, attempt, bytes, sha256) VALUES (?, ?, ?, ?, ?)")
      .bind(source.job)
      .bind(output.name)
      .bind(std::int64_t{output.attempt})
      .bind(static_cast<std::int64_t>(output.bytes))
      .bind(output.sha256)
      .run();
  return true;
}

}  // namespace surfaced::sqlite
