// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "artifacts/artifact_store.hpp"
#include "execution/stage_clock.hpp"
#include "jobs/job_events.hpp"
#include "jobs/job_store.hpp"
#include "worker/attempt_runner.hpp"

namespace surfaced {

/// Takes jobs from the store, oldest first, and runs them: a thread a worker, a child process an attempt. One more
/// thread renews the leases of what runs here, and gives back what runs nowhere any more.
///
/// Who owns what: a claimed job is the worker's until it is settled. On the way there the worker
/// publishes the outputs, then settles outputs and state in one transaction; if that says that the claim
/// is void (dismissed meanwhile), it discards what it published. While the store fails, the worker tries
/// again; if the server ends first, the next start recovers the job.
class Scheduler {
 public:
  /// What is told of every attempt that ends here.
  struct Ended {
    const ClaimedJob& job;
    const AttemptResult& result;
    /// Stages as the child named them, with the seconds between one name and the next.
    const std::vector<std::pair<std::string, double>>& stages;
  };

  struct Options {
    unsigned workers = 1;
    AttemptLimits limits;
    /// Between two renewals of the leases of running attempts; a third of the lease is right.
    std::chrono::milliseconds heartbeat{10'000};
    /// Called on a worker's thread. If it throws, the job is not settled: it is given back when its lease is over.
    std::function<void(const Ended&)> ended;
  };

  Scheduler(JobStore& jobs, ArtifactStore& artifacts, JobEvents& events, const AttemptRunner& runner, Options options);
  ~Scheduler();
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  void start();

  /// A job was submitted.
  void wake();

  /// Stops the attempt that works on this job, if there is one here.
  void cancel(std::string_view job);

  /// Claims no more; gives running attempts this long, then stops them and gives their jobs back.
  void drain(std::chrono::milliseconds grace);

 private:
  struct Running {
    Claim claim;
    std::shared_ptr<StopSignal> stop;
  };

  void work();
  void pulse();
  void renew_leases();
  void expire_leases();
  enum class Look : std::uint8_t { worked, nothing_to_do, failed };
  Look work_on_next();
  void run_claimed(const ClaimedJob& claimed, StopSignal& stop);
  /// What `attempt` throws (memory runs out in the server) loses the attempt and not the worker.
  AttemptResult attempt_safely(const ClaimedJob& claimed, const StopSignal& stop, StageClock& stages);
  AttemptResult attempt(const ClaimedJob& claimed, const StopSignal& stop, StageClock& stages);
  void settle(const ClaimedJob& claimed, AttemptResult result);
  /// Keeps what the attempt left; changes the result if that cannot be kept or is not complete.
  std::vector<Output> publish(const Job& job, AttemptResult& result);
  /// False when the scheduler stops.
  bool pause_after_failure();

  JobStore& jobs_;
  ArtifactStore& artifacts_;
  JobEvents& events_;
  const AttemptRunner& runner_;
  const Options options_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable idle_;
  std::uint64_t submissions_ = 0;
  bool stopping_ = false;
  // Two attempts at one job may overlap: one whose claim is void and has not noticed yet.
  std::vector<Running> running_;
  std::vector<std::thread> threads_;
  std::thread pulse_;
};

}  // namespace surfaced
