// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/sqlite_job_store.hpp"

#include <sqlite3.h>

#include <mutex>
#include <unordered_map>
#include <utility>

#include "jobs/sqlite/database.hpp"
#include "jobs/sqlite/errors.hpp"
#include "jobs/sqlite/holding_rows.hpp"
#include "jobs/sqlite/job_rows.hpp"
#include "jobs/sqlite/listing_rows.hpp"
#include "jobs/sqlite/patient_mutex.hpp"
#include "jobs/sqlite/schema.hpp"

namespace surfaced {
namespace {

using namespace sqlite;

struct LiveProgress {
  std::uint32_t attempt = 0;
  double fraction = 0;
  std::string phase;
};

/// A renewable claim as this process has last heard of it.
struct SeenHeartbeat {
  std::uint32_t attempt = 0;
  std::int64_t heartbeat = 0;
  std::chrono::steady_clock::time_point when;
};

/// One connection writes, another reads, each under its own mutex: a read never waits for the disk.
class SqliteJobStore final : public JobStore {
 public:
  SqliteJobStore(const std::filesystem::path& file, const JobStoreLimits& limits)
      : limits_(limits), writer_(file, limits.patience), reader_(file, limits.patience) {
    migrate(writer_);
  }

  Result<Job> submit(const NewJob& job, const Allowance& allowance) override {
    return guarded([&]() -> Result<Job> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      if (Status room = room_in(writer_); !room.ok()) return room.error();
      const Demand demand{1, job.of_stored_cloud() ? 0 : job.input.bytes};
      if (Status may = admit(writer_, job.owner, allowance, demand); !may.ok()) return may.error();
      if (job.of_stored_cloud() && !use_cloud(writer_, job.input.key, now())) {
        return Error{ErrorCode::cloud_not_found, "the cloud '" + job.input.key + "' was deleted meanwhile"};
      }
      insert_job(writer_, job, now());
      if (!job.idempotency_key.empty()) insert_idempotency(writer_, job);
      auto stored = *select_job(writer_, job.id);
      transaction.commit();
      return std::move(stored.job);
    });
  }

  Result<std::optional<Replay>> replay(std::string_view owner, std::string_view key) override {
    return guarded([&]() -> Result<std::optional<Replay>> {
      const std::scoped_lock lock(read_mutex_);
      return select_replay(reader_, owner, key);
    });
  }

  Result<JobPage> list(const JobFilter& filter, std::size_t limit, std::optional<std::int64_t> before) override {
    return guarded([&]() -> Result<JobPage> {
      JobPage page;
      {
        const std::scoped_lock lock(read_mutex_);
        const Transaction transaction(reader_, Transaction::Kind::read);
        page = select_page(reader_, filter, limit, before);
      }
      for (Job& job : page.jobs) add_progress(job);
      return page;
    });
  }

  Result<std::string> owner_of(std::string_view id) override {
    return guarded([&]() -> Result<std::string> {
      const std::scoped_lock lock(read_mutex_);
      auto owner = select_owner(reader_, id);
      if (owner) return std::move(*owner);
      return no_such_job(id);
    });
  }

  Result<Holding> holding_of(std::string_view owner) override {
    return guarded([&]() -> Result<Holding> {
      const std::scoped_lock lock(read_mutex_);
      const Transaction transaction(reader_, Transaction::Kind::read);
      return select_holding(reader_, owner);
    });
  }

  Result<std::size_t> recount_holdings() override {
    return guarded([&]() -> Result<std::size_t> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      const std::size_t wrong = count_wrong_holdings(writer_);
      if (wrong > 0) sqlite::recount_holdings(writer_);
      transaction.commit();
      return wrong;
    });
  }

  Result<bool> add_output(const Claim& source, const Output& output) override {
    return guarded([&]() -> Result<bool> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      if (!insert_output(writer_, source, output)) return false;
      transaction.commit();
      return true;
    });
  }

  Status check_room() override {
    return guarded([&] {
      const std::scoped_lock lock(read_mutex_);
      return room_in(reader_);
    });
  }

  Result<Job> find(std::string_view id) override {
    return guarded([&]() -> Result<Job> {
      std::optional<JobRow> row;
      {
        const std::scoped_lock lock(read_mutex_);
        const Transaction transaction(reader_, Transaction::Kind::read);
        row = select_job(reader_, id);
      }
      if (Status there = present(row, id); !there.ok()) return there.error();
      add_progress(row->job);
      return std::move(row->job);
    });
  }

  Result<std::optional<ClaimedJob>> claim() override {
    return guarded([&]() -> Result<std::optional<ClaimedJob>> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      const auto id = claim_oldest(writer_, now());
      if (!id) return std::optional<ClaimedJob>();
      auto row = select_job(writer_, *id);
      transaction.commit();
      const std::scoped_lock progress_lock(progress_mutex_);
      progress_[*id] = {row->job.attempt, 0, {}};
      return std::optional(ClaimedJob{std::move(row->job)});
    });
  }

  void report(const Claim& claim, double progress, std::string_view phase) override {
    const std::scoped_lock lock(progress_mutex_);
    const auto found = progress_.find(claim.job);
    if (found == progress_.end() || found->second.attempt != claim.attempt) return;
    found->second.fraction = std::max(found->second.fraction, progress);
    found->second.phase = phase;
  }

  Result<bool> renew(const Claim& claim) override {
    return guarded([&]() -> Result<bool> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      const bool holds = beat(writer_, claim);
      transaction.commit();
      return holds;
    });
  }

  Result<std::vector<Claim>> expire_leases() override {
    return guarded([&]() -> Result<std::vector<Claim>> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      const std::vector<Claim> silent = silent_claims();
      Ending ending;
      ending.error = Error{ErrorCode::lost, "the worker was silent for " + std::to_string(limits_.lease.count()) +
                                                " ms, " + std::to_string(kLossesAllowed) + " times under this job"};
      for (const Claim& claim : silent) settle_claim(writer_, claim, ending, now());
      transaction.commit();
      for (const Claim& claim : silent) heartbeats_.erase(claim.job);
      return silent;
    });
  }

  Result<std::optional<JobStatus>> settle(const Claim& claim, const Ending& ending) override {
    return guarded([&]() -> Result<std::optional<JobStatus>> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      const auto status = settle_claim(writer_, claim, ending, now());
      if (status) transaction.commit();
      forget_progress(claim);
      return status;
    });
  }

  Result<Retry> retry(std::string_view id, const Allowance& allowance) override {
    return guarded([&]() -> Result<Retry> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      const auto row = select_job(writer_, id);
      if (Status there = present(row, id); !there.ok()) return there.error();
      const JobStatus status = row->job.status;
      if (status != JobStatus::failed && status != JobStatus::dismissed) {
        return Error{ErrorCode::not_retryable, "job " + row->job.id + " is " + std::string(name_of(status)) +
                                                   "; only a failed or dismissed job can be tried again"};
      }
      if (Status room = room_in(writer_); !room.ok()) return room.error();
      if (Status may = admit(writer_, row->job.owner, allowance, {1, 0}); !may.ok()) return may.error();
      Artifacts garbage = requeue_ended(writer_, row->job);
      auto queued = *select_job(writer_, id);
      transaction.commit();
      return Retry{std::move(queued.job), std::move(garbage)};
    });
  }

  Result<Dismissal> dismiss(std::string_view id) override {
    return guarded([&]() -> Result<Dismissal> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      const auto row = select_job(writer_, id);
      if (Status there = present(row, id); !there.ok()) return there.error();
      const SystemTime time = now();
      Dismissal dismissal{ended(row->job.status), {}};
      if (dismissal.removed) {
        dismissal.garbage = remove_job(writer_, row->job, time, time + limits_.tombstone);
      } else {
        dismiss_job(writer_, row->job, time);
      }
      transaction.commit();
      return dismissal;
    });
  }

  Result<std::size_t> recover() override {
    return guarded([&]() -> Result<std::size_t> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      const auto running = select_running(writer_);
      Ending ending;
      ending.error =
          Error{ErrorCode::lost, "the server died " + std::to_string(kLossesAllowed) + " times under this job"};
      for (const Beating& each : running) settle_claim(writer_, each.claim, ending, now());
      transaction.commit();
      return running.size();
    });
  }

  Result<Artifacts> expire() override {
    return guarded([&]() -> Result<Artifacts> {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      const SystemTime time = now();
      purge_tombstones(writer_, time);
      Artifacts garbage;
      for (const auto& id : select_expired(writer_, time)) {
        const auto row = select_job(writer_, id);
        const Artifacts of_job = remove_job(writer_, row->job, time, time + limits_.tombstone);
        garbage.inputs.insert(garbage.inputs.end(), of_job.inputs.begin(), of_job.inputs.end());
        garbage.outputs.insert(garbage.outputs.end(), of_job.outputs.begin(), of_job.outputs.end());
      }
      transaction.commit();
      return garbage;
    });
  }

  Result<Artifacts> kept() override {
    return guarded([&]() -> Result<Artifacts> {
      const std::scoped_lock lock(read_mutex_);
      const Transaction transaction(reader_, Transaction::Kind::read);
      return Artifacts{select_inputs(reader_), select_published(reader_)};
    });
  }

  Result<Census> census() override {
    return guarded([&]() -> Result<Census> {
      const std::scoped_lock lock(read_mutex_);
      const Transaction transaction(reader_, Transaction::Kind::read);
      return select_census(reader_);
    });
  }

  Result<std::string> identity() override {
    return guarded([&]() -> Result<std::string> {
      const std::scoped_lock lock(read_mutex_);
      return select_identity(reader_);
    });
  }

  Status writable() override {
    return guarded([&]() -> Status {
      const auto lock = lock_writer();
      Transaction transaction(writer_, Transaction::Kind::write);
      transaction.commit();
      return Done{};
    });
  }

 private:
  /// Whoever holds it may itself wait for another process: nobody behind waits longer than that.
  std::unique_lock<PatientMutex> lock_writer() {
    std::unique_lock lock(write_mutex_, limits_.patience);
    if (!lock) {
      throw SqliteError(SQLITE_BUSY, "the job store is busy since " + std::to_string(limits_.patience.count()) + " ms");
    }
    return lock;
  }

  /// Notes who has renewed its claim, and returns those who have not for the time of a lease.
  std::vector<Claim> silent_claims() {
    const auto time = std::chrono::steady_clock::now();
    std::vector<Claim> silent;
    std::unordered_map<std::string, SeenHeartbeat> heartbeats;
    for (const Beating& each : select_running(writer_)) {
      SeenHeartbeat current{each.claim.attempt, each.heartbeat, time};
      const auto before = heartbeats_.find(each.claim.job);
      const bool unchanged = before != heartbeats_.end() && before->second.attempt == each.claim.attempt &&
                             before->second.heartbeat == each.heartbeat;
      if (unchanged) current.when = before->second.when;
      if (time - current.when >= limits_.lease) silent.push_back(each.claim);
      heartbeats.emplace(each.claim.job, current);
    }
    heartbeats_ = std::move(heartbeats);
    return silent;
  }

  Status room_in(Database& database) const {
    const auto waiting = count_accepted(database);
    if (waiting < limits_.queue) return Done{};
    return Error{ErrorCode::queue_full,
                 std::to_string(waiting) + " jobs are waiting, the limit is " + std::to_string(limits_.queue)};
  }

  static Status present(const std::optional<JobRow>& row, std::string_view id) {
    if (!row) return no_such_job(id);
    if (row->removed_at.empty()) return Done{};
    return with_fault({ErrorCode::job_gone, "the job '" + std::string(id) + "' was removed at " + row->removed_at},
                      {"id", std::string(id), "the id of a job that was not removed"});
  }

  void add_progress(Job& job) {
    if (job.status == JobStatus::successful) job.progress = 1;
    if (job.status != JobStatus::running) return;
    const std::scoped_lock lock(progress_mutex_);
    const auto found = progress_.find(job.id);
    if (found == progress_.end() || found->second.attempt != job.attempt) return;
    job.progress = found->second.fraction;
    job.phase = found->second.phase;
  }

  void forget_progress(const Claim& claim) {
    const std::scoped_lock lock(progress_mutex_);
    const auto found = progress_.find(claim.job);
    if (found != progress_.end() && found->second.attempt == claim.attempt) progress_.erase(found);
  }

  const JobStoreLimits limits_;
  PatientMutex write_mutex_;
  std::mutex read_mutex_;
  std::mutex progress_mutex_;
  Database writer_;
  Database reader_;
  std::unordered_map<std::string, LiveProgress> progress_;
  // Under the writer's lock.
  std::unordered_map<std::string, SeenHeartbeat> heartbeats_;
};

}  // namespace

Result<std::unique_ptr<JobStore>> open_sqlite_job_store(const std::filesystem::path& file,
                                                        const JobStoreLimits& limits) {
  return guarded([&]() -> Result<std::unique_ptr<JobStore>> {
    return std::unique_ptr<JobStore>(std::make_unique<SqliteJobStore>(file, limits));
  });
}

}  // namespace surfaced
