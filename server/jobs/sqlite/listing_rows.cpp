// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/sqlite/listing_rows.hpp"

#include <array>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "jobs/sqlite/job_rows.hpp"

namespace surfaced::sqlite {
namespace {

/// Methods of a filter for each of which the index is asked; beyond, rows are looked at one by one.
constexpr std::size_t kMostMethods = 16;
constexpr auto kStatuses = std::to_array(
    {JobStatus::accepted, JobStatus::running, JobStatus::successful, JobStatus::failed, JobStatus::dismissed});

/// A page's query, whose first condition an index answers; the others are looked at row by row, so '+' keeps their
/// indexes from being chosen. Statements are kept by the address of their text.
std::string query_with(std::string_view first) {
  return "SELECT id, seq FROM jobs WHERE removed_at IS NULL AND " + std::string(first) +
         "seq < ?1 AND (?2 = '[]' OR +status IN (SELECT value FROM json_each(?2))) "
         "AND (?3 = '[]' OR +method IN (SELECT value FROM json_each(?3))) "
         // Labels are stored as JSON, and have no character that JSON would write in another way.
         // The first is looked for alone, as few jobs have it.
         "AND (?11 = '' OR instr(labels, ?11) > 0) AND (?4 = '[]' OR NOT EXISTS (SELECT 1 FROM json_each(?4) AS asked "
         "WHERE instr(jobs.labels, json_quote(asked.value)) = 0)) "
         "AND (?5 = '' OR created_at >= ?5) AND (?6 = '' OR created_at <= ?6) "
         "AND (?7 < 0 OR (julianday(coalesce(finished_at, ?9)) - julianday(started_at)) * 86400 >= ?7) "
         "AND (?8 < 0 OR (julianday(coalesce(finished_at, ?9)) - julianday(started_at)) * 86400 <= ?8) "
         "ORDER BY seq DESC LIMIT ?10";
}
const std::string kOfAll = query_with("");
const std::string kOfOwner = query_with("owner = ?12 AND ");
const std::string kOfStatus = query_with("status = ?12 AND ");
const std::string kOfMethod = query_with("status = ?12 AND method = ?13 AND ");

/// One question to an index, which gives the newest jobs of one status or method, and not of several.
struct Slice {
  const std::string* query = &kOfAll;
  std::vector<std::string> first{};
};

std::vector<Slice> slices_of(const JobFilter& filter) {
  if (filter.owner) return {{&kOfOwner, {*filter.owner}}};
  const bool by_method = !filter.methods.empty() && filter.methods.size() <= kMostMethods;
  std::set<JobStatus> statuses(filter.statuses.begin(), filter.statuses.end());
  if (by_method && statuses.empty()) statuses.insert(kStatuses.begin(), kStatuses.end());
  if (statuses.empty()) return {Slice{}};
  std::vector<Slice> slices;
  for (const JobStatus status : statuses) {
    const std::string name(name_of(status));
    if (!by_method) slices.push_back({&kOfStatus, {name}});
    if (!by_method) continue;
    for (const std::string& method : filter.methods) slices.push_back({&kOfMethod, {name, method}});
  }
  return slices;
}

/// A filter as it is bound.
struct Bound {
  explicit Bound(const JobFilter& filter)
      : methods(nlohmann::json(filter.methods).dump()),
        labels(nlohmann::json(filter.labels).dump()),
        first_label(filter.labels.empty() ? std::string() : nlohmann::json(filter.labels.front()).dump()),
        from(filter.created_from ? to_rfc3339(*filter.created_from) : std::string()),
        to(filter.created_to ? to_rfc3339(*filter.created_to) : std::string()),
        time(to_rfc3339(now())) {
    nlohmann::json names = nlohmann::json::array();
    for (const JobStatus status : filter.statuses) names.push_back(name_of(status));
    statuses = names.dump();
  }
  std::string statuses;
  std::string methods;
  std::string labels;
  std::string first_label;
  std::string from;
  std::string to;
  std::string time;
};

}  // namespace

JobPage select_page(Database& database, const JobFilter& filter, std::size_t limit,
                    std::optional<std::int64_t> before) {
  const Bound bound(filter);
  std::map<std::int64_t, std::string, std::greater<>> found;
  for (const Slice& slice : slices_of(filter)) {
    Query query(database, slice.query->c_str());
    query.bind(before.value_or(std::numeric_limits<std::int64_t>::max()));
    query.bind(bound.statuses).bind(bound.methods).bind(bound.labels).bind(bound.from).bind(bound.to);
    query.bind(filter.shortest.value_or(-1)).bind(filter.longest.value_or(-1)).bind(bound.time);
    query.bind(static_cast<std::int64_t>(limit + 1)).bind(bound.first_label);
    for (const std::string& each : slice.first) query.bind(each);
    while (query.step()) found.emplace(query.number(1), query.text(0));
  }
  JobPage page;
  for (const auto& [seq, id] : found) {
    if (page.jobs.size() == limit) break;
    page.jobs.push_back(std::move(select_job(database, id)->job));
    if (page.jobs.size() == limit && found.size() > limit) page.next = seq;
  }
  return page;
}

std::optional<std::string> select_owner(Database& database, std::string_view id) {
  Query query(database, "SELECT owner FROM jobs WHERE id = ?");
  query.bind(id);
  return query.step() ? std::optional(query.text(0)) : std::nullopt;
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
  // Not INSERT OR REPLACE, which removes a row without its trigger.
  Query(database,
        "INSERT INTO outputs (job, name, attempt, bytes, sha256) VALUES (?, ?, ?, ?, ?) ON CONFLICT (job, name) DO "
        "UPDATE SET attempt = excluded.attempt, bytes = excluded.bytes, sha256 = excluded.sha256")
      .bind(source.job)
      .bind(output.name)
      .bind(std::int64_t{output.attempt})
      .bind(static_cast<std::int64_t>(output.bytes))
      .bind(output.sha256)
      .run();
  return true;
}

}  // namespace surfaced::sqlite
