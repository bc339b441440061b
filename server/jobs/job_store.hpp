// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "jobs/job.hpp"

namespace surfaced {

/// What a claim hands over: the job as it is now, running, with the claim's number in `job.attempt`.
struct ClaimedJob {
  Job job;
  Claim claim() const { return {job.id, job.attempt}; }
};

/// What the artifact store keeps for jobs: keys of inputs, and the claims under which outputs lie.
struct Artifacts {
  std::vector<std::string> inputs;
  std::vector<Claim> outputs;
};

/// What became of a request to dismiss a job.
struct Dismissal {
  /// Not removed: the job had not ended and is dismissed now; its attempt, if any, is still to be stopped.
  /// Removed: it had ended, and its record is gone.
  bool removed = false;
  /// To be removed from the artifact store.
  Artifacts garbage;
};

/// What a retry of an ended job leaves in the artifact store: the outputs of the attempts before.
struct Retry {
  Job job;
  Artifacts garbage;
};

/// Which jobs to list, newest first.
struct JobFilter {
  /// Of this owner alone; none for all.
  std::optional<std::string> owner;
  /// Any of these; empty for all.
  std::vector<JobStatus> statuses{};
  /// Any of these; empty for all.
  std::vector<std::string> methods{};
  /// A job has to have all of them.
  std::vector<std::string> labels{};
  std::optional<SystemTime> created_from{};
  std::optional<SystemTime> created_to{};
  /// Seconds from its beginning to its end, or to now; a job that has not begun has none.
  std::optional<double> shortest{};
  std::optional<double> longest{};
};

struct JobPage {
  std::vector<Job> jobs;
  /// Where the next page begins; none if this is the last.
  std::optional<std::int64_t> next;
};

/// A submission that the store has already.
struct Replay {
  std::string fingerprint;
  std::string job;
};

/// What belongs to an owner.
struct Holding {
  /// Jobs that wait or run.
  std::uint64_t active_jobs = 0;
  /// Bytes of inputs, stored clouds and outputs, and those that unfinished uploads have been promised.
  std::uint64_t bytes = 0;
};

/// What an owner may hold; 0 for no limit.
struct Allowance {
  std::uint64_t active_jobs = 0;
  std::uint64_t bytes = 0;

  /// quota_exceeded if so many jobs and bytes more are too many.
  Status check(const Holding& holding, std::uint64_t jobs, std::uint64_t bytes) const;
};

/// How many jobs there are now.
struct Census {
  std::uint64_t accepted = 0;
  std::uint64_t running = 0;
  /// When the oldest accepted job was submitted.
  std::optional<SystemTime> oldest_accepted;
};

/// How an attempt ended, as its worker tells it.
struct Ending {
  Outcome outcome = Outcome::lost;
  /// Unless the outcome is `done`.
  std::optional<Error> error{};
  std::vector<Output> outputs{};
  Usage usage{};
};

/// Where jobs are kept. Every change is durable when the call returns, or did not happen; a change in
/// the name of a claim happens only while that claim holds (fencing). All calls are safe in threads.
///
/// Errors: job_not_found, job_gone and queue_full where named; storage_full, not_ready (somebody else holds the
/// store) or internal_error if the store itself fails.
class JobStore {
 public:
  JobStore() = default;
  JobStore(const JobStore&) = delete;
  JobStore& operator=(const JobStore&) = delete;
  virtual ~JobStore() = default;

  /// Queues a job, together with its idempotency key if it has one.
  /// @param allowance  of its owner
  /// @return queue_full if the limit is reached; quota_exceeded if the owner may not have it; cloud_not_found if its
  ///         input is a stored cloud that is gone.
  virtual Result<Job> submit(const NewJob& job, const Allowance& allowance) = 0;
  Result<Job> submit(const NewJob& job) { return submit(job, {}); }

  /// What was submitted with this key before, if anything was.
  virtual Result<std::optional<Replay>> replay(std::string_view owner, std::string_view key) = 0;

  /// A page of jobs, in the order of their submission from the newest on.
  /// @param before  `next` of the page before; none for the first
  virtual Result<JobPage> list(const JobFilter& filter, std::size_t limit, std::optional<std::int64_t> before) = 0;

  /// Whose the job is, also of one that was removed.
  virtual Result<std::string> owner_of(std::string_view id) = 0;

  /// What the owner's jobs, clouds and uploads hold; at the cost of one row, however many they are.
  virtual Result<Holding> holding_of(std::string_view owner) = 0;

  /// Counts what everybody holds from the beginning, and puts right what is wrong.
  /// @return  of how many owners that was; it is 0 unless there is a defect
  virtual Result<std::size_t> recount_holdings() = 0;

  /// Adds an output that was made from those of a successful job.
  /// @param source  the attempt whose outputs it was made from; false, and nothing changed, if they are not the
  ///                job's outputs any more
  virtual Result<bool> add_output(const Claim& source, const Output& output) = 0;

  /// queue_full if `submit` would say so now.
  virtual Status check_room() = 0;

  /// The job, or job_not_found, job_gone.
  virtual Result<Job> find(std::string_view id) = 0;

  /// The oldest accepted job, now running; none if there is none.
  virtual Result<std::optional<ClaimedJob>> claim() = 0;

  /// How far the claim's attempt is. Not durable: it is of no use once the attempt is over.
  virtual void report(const Claim& claim, double progress, std::string_view phase) = 0;

  /// Renews the claim's lease: its worker lives.
  /// @return false if the claim does not hold any more; its worker shall stop.
  virtual Result<bool> renew(const Claim& claim) = 0;

  /// Gives back the jobs whose claims have not been renewed for the time of a lease, measured by this process's
  /// monotonic clock: a claim counts as silent from when this process first saw it unchanged, so that clocks that
  /// jump or differ between machines end no lease. To be called every few seconds.
  /// @return the claims that are void now.
  virtual Result<std::vector<Claim>> expire_leases() = 0;

  /// The attempt is over. Its outputs and the job's new state become visible together.
  /// @return the job's state after it, or none if the claim did not hold any more: then nothing changed.
  virtual Result<std::optional<JobStatus>> settle(const Claim& claim, const Ending& ending) = 0;

  /// Queues a failed or dismissed job again, at the end, with its failure_counts forgotten.
  /// @param allowance  of the job's owner
  /// @return job_not_found, job_gone, not_retryable, queue_full, quota_exceeded.
  virtual Result<Retry> retry(std::string_view id, const Allowance& allowance) = 0;
  Result<Retry> retry(std::string_view id) { return retry(id, {}); }

  /// Dismisses an active job, removes an ended one; job_not_found, job_gone.
  virtual Result<Dismissal> dismiss(std::string_view id) = 0;

  /// To be called once, before the first claim of a server that has the store for itself: whatever is running was
  /// lost with the server before it, and need not wait for its lease. Returns the number of those jobs.
  virtual Result<std::size_t> recover() = 0;

  /// Removes ended jobs whose time to live is over, and forgets those that were removed long ago.
  /// Returns what is to be removed from the artifact store, of a bounded number of jobs; nothing when
  /// there is nothing left to do.
  virtual Result<Artifacts> expire() = 0;

  /// Everything that is to be kept in the artifact store, outputs of running attempts included: they may be
  /// published and about to be settled.
  virtual Result<Artifacts> kept() = 0;

  virtual Result<Census> census() = 0;

  /// Which job store this is, for as long as its file lives: 128 random bits.
  virtual Result<std::string> identity() = 0;

  /// Done if a change could be made now.
  virtual Status writable() = 0;
};

}  // namespace surfaced
