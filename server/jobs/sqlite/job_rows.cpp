// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/sqlite/job_rows.hpp"

#include <algorithm>
#include <array>

#include "base/text.hpp"

namespace surfaced::sqlite {
namespace {

/// Attempts that are shown of a job. Drained ones are not bounded by any count.
constexpr std::int64_t kAttemptsShown = 50;

std::optional<SystemTime> time_at(const Query& query, int column) {
  if (query.null(column)) return std::nullopt;
  return from_rfc3339(query.text(column));
}

std::vector<Output> select_outputs(Database& database, std::string_view id) {
  std::vector<Output> outputs;
  Query query(database, "SELECT name, attempt, bytes, sha256 FROM outputs WHERE job = ? ORDER BY name");
  query.bind(id);
  while (query.step()) {
    outputs.push_back({query.text(0), static_cast<std::uint32_t>(query.number(1)),
                       static_cast<std::uint64_t>(query.number(2)), query.text(3)});
  }
  return outputs;
}

void replace_outputs(Database& database, std::string_view id, const std::vector<Output>& outputs) {
  Query(database, "DELETE FROM outputs WHERE job = ?").bind(id).run();
  for (const Output& output : outputs) {
    Query(database, "INSERT INTO outputs (job, name, attempt, bytes, sha256) VALUES (?, ?, ?, ?, ?)")
        .bind(id)
        .bind(output.name)
        .bind(std::int64_t{output.attempt})
        .bind(static_cast<std::int64_t>(output.bytes))
        .bind(output.sha256)
        .run();
  }
}

std::optional<Error> error_at(const Query& query, int column) {
  if (query.null(column)) return std::nullopt;
  ErrorCode code = ErrorCode::internal_error;
  error_code_named(query.text(column), code);
  return Error{code, query.text(column + 1)};
}

std::vector<Attempt> select_attempts(Database& database, std::string_view id) {
  std::vector<Attempt> attempts;
  Query query(database,
              "SELECT number, started_at, ended_at, outcome, seconds, cpu_seconds, peak_memory_bytes, error_code, "
              "error_detail FROM attempts WHERE job = ? ORDER BY number DESC LIMIT ?");
  query.bind(id).bind(kAttemptsShown);
  while (query.step()) {
    attempts.push_back({static_cast<std::uint32_t>(query.number(0)), time_at(query, 1).value_or(SystemTime{}),
                        time_at(query, 2), query.text(3),
                        Usage{query.real(4), query.real(5), static_cast<std::uint64_t>(query.number(6))},
                        error_at(query, 7)});
  }
  std::ranges::reverse(attempts);
  return attempts;
}

void end_attempt(Database& database, const Claim& claim, const Ending& ending, SystemTime time) {
  const std::string ended = to_rfc3339(time);
  Query update(database,
               "UPDATE attempts SET ended_at = ?, outcome = ?, seconds = ?, cpu_seconds = ?, peak_memory_bytes = ?, "
               "error_code = ?, error_detail = ? WHERE job = ? AND number = ?");
  update.bind(ended).bind(name_of(ending.outcome)).bind(ending.usage.seconds).bind(ending.usage.cpu_seconds);
  update.bind(static_cast<std::int64_t>(ending.usage.peak_memory_bytes)).bind(ending.error);
  update.bind(claim.job).bind(std::int64_t{claim.attempt}).run();
}

Artifacts published_by(const Job& job) {
  Artifacts garbage;
  for (const Output& output : job.outputs) {
    const bool known = !garbage.outputs.empty() && garbage.outputs.back().attempt == output.attempt;
    if (!known) garbage.outputs.push_back({job.id, output.attempt});
  }
  return garbage;
}

std::vector<std::string> texts_in(const std::string& json) {
  std::vector<std::string> texts;
  const auto list = nlohmann::json::parse(json, nullptr, false);
  if (!list.is_array()) return texts;
  for (const auto& each : list) {
    if (each.is_string()) texts.push_back(each.get<std::string>());
  }
  return texts;
}

/// The columns of a job that are read, in the order of the query.
constexpr auto kJobColumns = std::to_array<std::string_view>(
    {"id",           "method",       "parameters", "status",      "attempt",     "input_key",  "input_bytes",
     "input_sha256", "ttl_seconds",  "created_at", "started_at",  "finished_at", "expires_at", "removed_at",
     "error_code",   "error_detail", "wanted",     "request_id",  "seq",         "parked",     "traceparent",
     "owner",        "labels",       "webhook",    "presentation"});

/// Where the query has the column; one that it does not have is an error of the compiler.
consteval int column(std::string_view name) {
  const auto* const found = std::ranges::find(kJobColumns, name);
  if (found == kJobColumns.end()) throw "no such column";
  return static_cast<int>(found - kJobColumns.begin());
}
static_assert(column("error_detail") == column("error_code") + 1, "error_at reads the two together");

const std::string kSelectJob = "SELECT " + joined(kJobColumns) + " FROM jobs WHERE id = ?";

JobRow read_job(const Query& query) {
  JobRow row;
  Job& job = row.job;
  job.id = query.text(column("id"));
  job.method = query.text(column("method"));
  job.parameters = nlohmann::ordered_json::parse(query.text(column("parameters")), nullptr, false);
  const auto status = job_status_named(query.text(column("status")));
  if (!status || job.parameters.is_discarded()) {
    throw SqliteError(0, "the job store is damaged: job " + job.id + " has a status or parameters that cannot be read");
  }
  job.status = *status;
  job.attempt = static_cast<std::uint32_t>(query.number(column("attempt")));
  job.input = {query.text(column("input_key")), static_cast<std::uint64_t>(query.number(column("input_bytes"))),
               query.text(column("input_sha256"))};
  job.ttl = std::chrono::seconds(query.number(column("ttl_seconds")));
  job.created_at = time_at(query, column("created_at")).value_or(SystemTime{});
  job.started_at = time_at(query, column("started_at"));
  job.finished_at = time_at(query, column("finished_at"));
  job.expires_at = time_at(query, column("expires_at"));
  row.removed_at = query.text(column("removed_at"));
  row.seq = query.number(column("seq"));
  job.request_id = query.text(column("request_id"));
  job.wanted = texts_in(query.text(column("wanted")));
  job.error = error_at(query, column("error_code"));
  job.parked = query.number(column("parked")) != 0;
  job.traceparent = query.text(column("traceparent"));
  job.owner = query.text(column("owner"));
  job.labels = texts_in(query.text(column("labels")));
  job.webhook = query.text(column("webhook"));
  job.presentation = query.text(column("presentation"));
  return row;
}

std::vector<std::string> ids(Query& query) {
  std::vector<std::string> found;
  while (query.step()) found.push_back(query.text(0));
  return found;
}

std::vector<Claim> claims(Query& query) {
  std::vector<Claim> found;
  while (query.step()) found.push_back({query.text(0), static_cast<std::uint32_t>(query.number(1))});
  return found;
}

struct Standing {
  FailureCounts failure_counts;
  std::chrono::seconds ttl;
};

std::optional<Standing> standing_of(Database& database, const Claim& claim) {
  Query query(database,
              "SELECT failures, losses, ttl_seconds FROM jobs WHERE id = ? AND attempt = ? AND status = 'running'");
  query.bind(claim.job).bind(std::int64_t{claim.attempt});
  if (!query.step()) return std::nullopt;
  return Standing{{static_cast<std::uint32_t>(query.number(0)), static_cast<std::uint32_t>(query.number(1))},
                  std::chrono::seconds(query.number(2))};
}

void requeue(Database& database, const Claim& claim, const FailureCounts& failure_counts) {
  Query(database,
        "UPDATE jobs SET status = 'accepted', started_at = NULL, failures = ?, losses = ? "
        "WHERE id = ? AND attempt = ? AND status = 'running'")
      .bind(std::int64_t{failure_counts.failures})
      .bind(std::int64_t{failure_counts.losses})
      .bind(claim.job)
      .bind(std::int64_t{claim.attempt})
      .run();
}

JobStatus status_after(Outcome outcome) {
  if (outcome == Outcome::done) return JobStatus::successful;
  return outcome == Outcome::cancelled ? JobStatus::dismissed : JobStatus::failed;
}

}  // namespace

void insert_job(Database& database, const NewJob& job, SystemTime time) {
  const std::string parameters = job.parameters.dump();
  const std::string wanted = nlohmann::json(job.wanted).dump();
  const std::string created = to_rfc3339(time);
  const std::string labels = nlohmann::json(job.labels).dump();
  Query(database,
        "INSERT INTO jobs (id, method, parameters, status, input_key, input_bytes, input_sha256, wanted, request_id, "
        "traceparent, ttl_seconds, created_at, owner, labels, webhook, presentation) "
        "VALUES (?, ?, ?, 'accepted', ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(job.id)
      .bind(job.method)
      .bind(parameters)
      .bind(job.input.key)
      .bind(static_cast<std::int64_t>(job.input.bytes))
      .bind(job.input.sha256)
      .bind(wanted)
      .bind(job.request_id)
      .bind(job.traceparent)
      .bind(std::int64_t{job.ttl.count()})
      .bind(created)
      .bind(job.owner)
      .bind(labels)
      .bind(job.webhook)
      .bind(job.presentation)
      .run();
}

std::optional<JobRow> select_job(Database& database, std::string_view id) {
  std::optional<JobRow> row;
  {
    Query query(database, kSelectJob.c_str());
    query.bind(id);
    if (!query.step()) return std::nullopt;
    row = read_job(query);
  }
  if (row->job.status == JobStatus::accepted) {
    Query query(database, "SELECT count(*) FROM jobs WHERE status = 'accepted' AND seq < ?");
    query.bind(row->seq);
    if (query.step()) row->job.queue_position = static_cast<std::uint64_t>(query.number(0));
  }
  row->job.outputs = select_outputs(database, id);
  row->job.attempts = select_attempts(database, id);
  return row;
}

std::size_t count_accepted(Database& database) {
  Query query(database, "SELECT count(*) FROM jobs WHERE status = 'accepted'");
  query.step();
  return static_cast<std::size_t>(query.number(0));
}

std::optional<std::string> claim_oldest(Database& database, SystemTime time) {
  const std::string started = to_rfc3339(time);
  std::string id;
  std::int64_t attempt = 0;
  {
    Query query(database,
                "UPDATE jobs SET status = 'running', attempt = attempt + 1, heartbeat = 0, started_at = ? WHERE seq = "
                "(SELECT seq FROM jobs WHERE status = 'accepted' ORDER BY seq LIMIT 1) RETURNING id, attempt");
    query.bind(started);
    if (!query.step()) return std::nullopt;
    id = query.text(0);
    attempt = query.number(1);
    query.run();
  }
  Query(database, "INSERT INTO attempts (job, number, started_at) VALUES (?, ?, ?)")
      .bind(id)
      .bind(attempt)
      .bind(started)
      .run();
  return id;
}

bool beat(Database& database, const Claim& claim) {
  Query(database, "UPDATE jobs SET heartbeat = heartbeat + 1 WHERE id = ? AND attempt = ? AND status = 'running'")
      .bind(claim.job)
      .bind(std::int64_t{claim.attempt})
      .run();
  return database.changes() > 0;
}

std::optional<JobStatus> settle_claim(Database& database, const Claim& claim, const Ending& ending, SystemTime time) {
  const auto standing = standing_of(database, claim);
  if (!standing) return std::nullopt;
  end_attempt(database, claim, ending, time);
  const Verdict verdict = judge(ending.outcome, standing->failure_counts);
  if (verdict.again) {
    requeue(database, claim, verdict.failure_counts);
    return JobStatus::accepted;
  }
  const JobStatus status = status_after(ending.outcome);
  const std::string finished = to_rfc3339(time);
  const std::string expires = to_rfc3339(time + standing->ttl);
  Query update(database,
               "UPDATE jobs SET status = ?, finished_at = ?, expires_at = ?, failures = ?, losses = ?, parked = ?, "
               "error_code = ?, error_detail = ? WHERE id = ? AND attempt = ? AND status = 'running'");
  update.bind(name_of(status)).bind(finished).bind(expires);
  update.bind(std::int64_t{verdict.failure_counts.failures}).bind(std::int64_t{verdict.failure_counts.losses});
  update.bind(std::int64_t{verdict.parked}).bind(ending.error);
  update.bind(claim.job).bind(std::int64_t{claim.attempt}).run();
  replace_outputs(database, claim.job, ending.outputs);
  return status;
}

void dismiss_job(Database& database, const Job& job, SystemTime time) {
  const std::string finished = to_rfc3339(time);
  const std::string expiry = to_rfc3339(time + job.ttl);
  Query(database,
        "UPDATE jobs SET status = 'dismissed', finished_at = ?, expires_at = ? "
        "WHERE id = ? AND status IN ('accepted', 'running')")
      .bind(finished)
      .bind(expiry)
      .bind(job.id)
      .run();
  if (job.status != JobStatus::running) return;
  Ending ending;
  ending.outcome = Outcome::cancelled;
  end_attempt(database, {job.id, job.attempt}, ending, time);
}

Artifacts requeue_ended(Database& database, const Job& job) {
  Query(database, "DELETE FROM outputs WHERE job = ?").bind(job.id).run();
  Query(database,
        "UPDATE jobs SET status = 'accepted', started_at = NULL, finished_at = NULL, expires_at = NULL, failures = 0, "
        "losses = 0, parked = 0, error_code = NULL, error_detail = NULL, seq = (SELECT max(seq) + 1 FROM jobs) "
        "WHERE id = ? AND status IN ('failed', 'dismissed') AND removed_at IS NULL")
      .bind(job.id)
      .run();
  return published_by(job);
}

Artifacts remove_job(Database& database, const Job& job, SystemTime time, SystemTime expires) {
  const std::string removed = to_rfc3339(time);
  const std::string expiry = to_rfc3339(expires);
  Query(database, "DELETE FROM outputs WHERE job = ?").bind(job.id).run();
  Query(database, "DELETE FROM attempts WHERE job = ?").bind(job.id).run();
  Query(database, "UPDATE jobs SET removed_at = ?, expires_at = ? WHERE id = ? AND removed_at IS NULL")
      .bind(removed)
      .bind(expiry)
      .bind(job.id)
      .run();
  Artifacts garbage = published_by(job);
  // A stored cloud outlives its jobs.
  if (!job.of_stored_cloud()) garbage.inputs.push_back(job.input.key);
  return garbage;
}

void purge_tombstones(Database& database, SystemTime time) {
  const std::string limit = to_rfc3339(time);
  Query(database, "DELETE FROM jobs WHERE expires_at <= ? AND removed_at IS NOT NULL").bind(limit).run();
}

std::vector<Beating> select_running(Database& database) {
  Query query(database, "SELECT id, attempt, heartbeat FROM jobs WHERE status = 'running' ORDER BY seq");
  std::vector<Beating> found;
  while (query.step()) {
    found.push_back({{query.text(0), static_cast<std::uint32_t>(query.number(1))}, query.number(2)});
  }
  return found;
}

Census select_census(Database& database) {
  Census census;
  census.accepted = count_accepted(database);
  {
    Query running(database, "SELECT count(*) FROM jobs WHERE status = 'running'");
    if (running.step()) census.running = static_cast<std::uint64_t>(running.number(0));
  }
  Query oldest(database, "SELECT created_at FROM jobs WHERE status = 'accepted' ORDER BY seq LIMIT 1");
  if (oldest.step()) census.oldest_accepted = time_at(oldest, 0);
  return census;
}

std::string select_identity(Database& database) {
  Query query(database, "SELECT id FROM store");
  if (!query.step()) throw SqliteError(0, "the job store is damaged: it has lost its identity");
  return query.text(0);
}

std::vector<std::string> select_expired(Database& database, SystemTime time) {
  const std::string limit = to_rfc3339(time);
  Query query(database, "SELECT id FROM jobs WHERE expires_at <= ? AND removed_at IS NULL LIMIT 1000");
  query.bind(limit);
  return ids(query);
}

std::vector<std::string> select_inputs(Database& database) {
  Query query(database, "SELECT input_key FROM jobs WHERE removed_at IS NULL UNION SELECT id FROM clouds");
  return ids(query);
}

std::vector<Claim> select_published(Database& database) {
  Query query(database,
              "SELECT DISTINCT job, attempt FROM outputs UNION "
              "SELECT id, attempt FROM jobs WHERE status = 'running'");
  return claims(query);
}

}  // namespace surfaced::sqlite
