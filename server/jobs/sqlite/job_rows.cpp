#include "jobs/sqlite/job_rows.hpp"

#include <charconv>

namespace surfaced::sqlite {
namespace {

/// Reads what to_rfc3339 wrote.
std::optional<SystemTime> time_at(const Query& query, int column) {
  if (query.null(column)) return std::nullopt;
  const std::string text = query.text(column);
  const auto part = [&](std::size_t at, std::size_t length) {
    unsigned value = 0;
    if (text.size() >= at + length) std::from_chars(text.data() + at, text.data() + at + length, value);
    return value;
  };
  using namespace std::chrono;
  const auto day = year(static_cast<int>(part(0, 4))) / month(part(5, 2)) / std::chrono::day(part(8, 2));
  return SystemTime(sys_days(day) + hours(part(11, 2)) + minutes(part(14, 2)) + seconds(part(17, 2)) +
                    milliseconds(part(20, 3)));
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

JobRow read_job(const Query& query) {
  JobRow row;
  Job& job = row.job;
  job.id = query.text(0);
  job.method = query.text(1);
  job.parameters = nlohmann::ordered_json::parse(query.text(2), nullptr, false);
  const auto status = job_status_named(query.text(3));
  if (!status || job.parameters.is_discarded()) {
    throw SqliteError(0, "the job store is damaged: job " + job.id + " has a status or parameters that cannot be read");
  }
  job.status = *status;
  job.attempt = static_cast<std::uint32_t>(query.number(4));
  job.input = {query.text(5), static_cast<std::uint64_t>(query.number(6)), query.text(7)};
  job.ttl = std::chrono::seconds(query.number(8));
  job.created_at = time_at(query, 9).value_or(SystemTime{});
  job.started_at = time_at(query, 10);
  job.finished_at = time_at(query, 11);
  job.expires_at = time_at(query, 12);
  row.removed_at = query.text(13);
  job.request_id = query.text(17);
  const auto wanted = nlohmann::json::parse(query.text(16), nullptr, false);
  if (wanted.is_array()) {
    for (const auto& name : wanted) job.wanted.push_back(name.get<std::string>());
  }
  if (!query.null(14)) {
    ErrorCode code = ErrorCode::internal_error;
    error_code_named(query.text(14), code);
    job.error = Error{code, query.text(15)};
  }
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
  Mishaps mishaps;
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

void requeue(Database& database, const Claim& claim, const Mishaps& mishaps) {
  Query(database,
        "UPDATE jobs SET status = 'accepted', started_at = NULL, failures = ?, losses = ? "
        "WHERE id = ? AND attempt = ? AND status = 'running'")
      .bind(std::int64_t{mishaps.failures})
      .bind(std::int64_t{mishaps.losses})
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
  Query(database,
        "INSERT INTO jobs (id, method, parameters, status, input_key, input_bytes, input_sha256, wanted, request_id, "
        "ttl_seconds, created_at) VALUES (?, ?, ?, 'accepted', ?, ?, ?, ?, ?, ?, ?)")
      .bind(job.id)
      .bind(job.method)
      .bind(parameters)
      .bind(job.input.key)
      .bind(static_cast<std::int64_t>(job.input.bytes))
      .bind(job.input.sha256)
      .bind(wanted)
      .bind(job.request_id)
      .bind(std::int64_t{job.ttl.count()})
      .bind(created)
      .run();
}

std::optional<JobRow> select_job(Database& database, std::string_view id) {
  std::optional<JobRow> row;
  std::int64_t seq = 0;
  {
    Query query(database,
                "SELECT id, method, parameters, status, attempt, input_key, input_bytes, input_sha256, ttl_seconds, "
                "created_at, started_at, finished_at, expires_at, removed_at, error_code, error_detail, wanted, "
                "request_id, seq "
                "FROM jobs WHERE id = ?");
    query.bind(id);
    if (!query.step()) return std::nullopt;
    row = read_job(query);
    seq = query.number(18);
  }
  if (row->job.status == JobStatus::accepted) {
    Query query(database, "SELECT count(*) FROM jobs WHERE status = 'accepted' AND seq < ?");
    query.bind(seq);
    if (query.step()) row->job.queue_position = static_cast<std::uint64_t>(query.number(0));
  }
  row->job.outputs = select_outputs(database, id);
  return row;
}

std::size_t count_accepted(Database& database) {
  Query query(database, "SELECT count(*) FROM jobs WHERE status = 'accepted'");
  query.step();
  return static_cast<std::size_t>(query.number(0));
}

std::optional<std::string> claim_oldest(Database& database, SystemTime time) {
  const std::string started = to_rfc3339(time);
  Query query(database,
              "UPDATE jobs SET status = 'running', attempt = attempt + 1, started_at = ? WHERE seq = "
              "(SELECT seq FROM jobs WHERE status = 'accepted' ORDER BY seq LIMIT 1) RETURNING id");
  query.bind(started);
  if (!query.step()) return std::nullopt;
  std::string id = query.text(0);
  query.run();
  return id;
}

std::optional<JobStatus> settle_claim(Database& database, const Settlement& settlement) {
  const auto standing = standing_of(database, settlement.claim);
  if (!standing) return std::nullopt;
  const Verdict verdict = judge(settlement.outcome, standing->mishaps);
  if (verdict.again) {
    requeue(database, settlement.claim, verdict.mishaps);
    return JobStatus::accepted;
  }
  const JobStatus status = status_after(settlement.outcome);
  const std::string finished = to_rfc3339(settlement.time);
  const std::string expires = to_rfc3339(settlement.time + standing->ttl);
  Query update(database,
               "UPDATE jobs SET status = ?, finished_at = ?, expires_at = ?, failures = ?, losses = ?, error_code = ?, "
               "error_detail = ? WHERE id = ? AND attempt = ? AND status = 'running'");
  update.bind(name_of(status)).bind(finished).bind(expires);
  update.bind(std::int64_t{verdict.mishaps.failures}).bind(std::int64_t{verdict.mishaps.losses});
  if (settlement.error) {
    update.bind(name_of(settlement.error->code)).bind(settlement.error->detail);
  } else {
    update.bind(nullptr).bind(nullptr);
  }
  update.bind(settlement.claim.job).bind(std::int64_t{settlement.claim.attempt}).run();
  replace_outputs(database, settlement.claim.job, settlement.outputs);
  return status;
}

void dismiss_job(Database& database, std::string_view id, SystemTime time, SystemTime expires) {
  const std::string finished = to_rfc3339(time);
  const std::string expiry = to_rfc3339(expires);
  Query(database,
        "UPDATE jobs SET status = 'dismissed', finished_at = ?, expires_at = ? "
        "WHERE id = ? AND status IN ('accepted', 'running')")
      .bind(finished)
      .bind(expiry)
      .bind(id)
      .run();
}

Artifacts remove_job(Database& database, const Job& job, SystemTime time, SystemTime expires) {
  const std::string removed = to_rfc3339(time);
  const std::string expiry = to_rfc3339(expires);
  Query(database, "DELETE FROM outputs WHERE job = ?").bind(job.id).run();
  Query(database, "UPDATE jobs SET removed_at = ?, expires_at = ? WHERE id = ? AND removed_at IS NULL")
      .bind(removed)
      .bind(expiry)
      .bind(job.id)
      .run();
  Artifacts garbage{{job.input.key}, {}};
  for (const Output& output : job.outputs) {
    const bool known = !garbage.outputs.empty() && garbage.outputs.back().attempt == output.attempt;
    if (!known) garbage.outputs.push_back({job.id, output.attempt});
  }
  return garbage;
}

void purge_tombstones(Database& database, SystemTime time) {
  const std::string limit = to_rfc3339(time);
  Query(database, "DELETE FROM jobs WHERE expires_at <= ? AND removed_at IS NOT NULL").bind(limit).run();
}

std::vector<Claim> select_running(Database& database) {
  Query query(database, "SELECT id, attempt FROM jobs WHERE status = 'running' ORDER BY seq");
  return claims(query);
}

std::vector<std::string> select_expired(Database& database, SystemTime time) {
  const std::string limit = to_rfc3339(time);
  Query query(database, "SELECT id FROM jobs WHERE expires_at <= ? AND removed_at IS NULL LIMIT 1000");
  query.bind(limit);
  return ids(query);
}

std::vector<std::string> select_inputs(Database& database) {
  Query query(database, "SELECT input_key FROM jobs WHERE removed_at IS NULL");
  return ids(query);
}

std::vector<Claim> select_published(Database& database) {
  Query query(database, "SELECT DISTINCT job, attempt FROM outputs");
  return claims(query);
}

}  // namespace surfaced::sqlite
