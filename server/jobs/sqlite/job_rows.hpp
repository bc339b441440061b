// SPDX-License-Identifier: GPL-3.0-or-later
// What the store does with its tables, a function per step; each runs inside a transaction of the
// caller and throws SqliteError.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "jobs/job.hpp"
#include "jobs/job_store.hpp"
#include "jobs/sqlite/database.hpp"

namespace surfaced::sqlite {

struct JobRow {
  Job job;
  /// Empty unless the job was removed.
  std::string removed_at;
  /// Its number in the order of submission.
  std::int64_t seq = 0;
};

void insert_job(Database& database, const NewJob& job, SystemTime time);

/// The job with its outputs and its place in the queue, whether it was removed or not.
std::optional<JobRow> select_job(Database& database, std::string_view id);

std::size_t count_accepted(Database& database);

/// The oldest accepted job becomes running, with a new attempt; returns its id.
std::optional<std::string> claim_oldest(Database& database, SystemTime time);

/// Moves the job on; none, and nothing changed, if the claim does not hold.
std::optional<JobStatus> settle_claim(Database& database, const Claim& claim, const Ending& ending, SystemTime time);

/// False if the claim does not hold.
bool beat(Database& database, const Claim& claim);

void dismiss_job(Database& database, const Job& job, SystemTime time);

/// Makes an ended job accepted again, at the end of the queue; returns its outputs as garbage.
Artifacts requeue_ended(Database& database, const Job& job);

/// Leaves a tombstone that expires; returns what the job has in the artifact store.
Artifacts remove_job(Database& database, const Job& job, SystemTime time, SystemTime expires);
void purge_tombstones(Database& database, SystemTime time);

/// A running job's claim, and how often it was renewed.
struct Beating {
  Claim claim;
  std::int64_t heartbeat = 0;
};
std::vector<Beating> select_running(Database& database);
Census select_census(Database& database);
std::string select_identity(Database& database);
std::vector<std::string> select_expired(Database& database, SystemTime time);
std::vector<std::string> select_inputs(Database& database);
std::vector<Claim> select_published(Database& database);

}  // namespace surfaced::sqlite
