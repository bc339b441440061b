// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "api/incoming.hpp"
#include "api/submission.hpp"
#include "artifacts/artifact_store.hpp"
#include "clouds/cloud_service.hpp"
#include "execution/renditions.hpp"
#include "execution/scheduler.hpp"
#include "http/message.hpp"
#include "jobs/job_events.hpp"
#include "jobs/job_store.hpp"

namespace surfaced::api {

/// Who asks, and by what his job is found again in logs and traces.
struct RequestContext {
  std::string request_id;
  std::string traceparent;
  http::Caller caller;
  /// Empty if the request has none.
  std::string idempotency_key{};
};

/// Idempotency keys of requests that are being worked on.
class KeysInFlight {
 public:
  /// Gives the key back when it is destroyed.
  class Turn {
   public:
    Turn() = default;
    Turn(KeysInFlight& keys, std::string entry) : keys_(&keys), entry_(std::move(entry)) {}
    Turn(Turn&& other) noexcept : keys_(std::exchange(other.keys_, nullptr)), entry_(std::move(other.entry_)) {}
    Turn& operator=(Turn&&) = delete;
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn();

   private:
    KeysInFlight* keys_ = nullptr;
    std::string entry_;
  };
  Result<Turn> take(const RequestContext& context);

 private:
  std::mutex mutex_;
  std::set<std::string> held_;
};

/// What the endpoints of the service do with jobs: take one in, wait for one, end one. Knows stores and
/// scheduler, not how answers look.
class JobService {
 public:
  JobService(JobStore& jobs, ArtifactStore& artifacts, CloudService& clouds, Renditions& renditions, JobEvents& events,
             Scheduler& scheduler);

  /// Room for a cloud on its way in; storage_full, not_ready, quota_exceeded.
  /// @param needed  bytes that are known to come
  Result<std::unique_ptr<Upload>> begin_upload(const http::Caller& caller, std::uint64_t needed = 0);

  Status check_space(std::uint64_t needed) { return artifacts_.check_space(needed); }

  /// Holds the request's idempotency key until the answer is known; request_in_flight if another request holds it.
  Result<KeysInFlight::Turn> take_turn(const RequestContext& context) { return keys_.take(context); }

  struct Submitted {
    Job job;
    /// The same submission was made before with the same key; nothing new was queued.
    bool replayed = false;
  };
  /// Queues a job; durable when the call returns.
  /// @param cloud  what the request brought; none if the submission names a stored cloud
  /// @return  queue_full, storage_full, quota_exceeded, cloud_not_found, idempotency_mismatch.
  Result<Submitted> submit(const Submission& submission, std::unique_ptr<Upload> cloud, const RequestContext& context);

  Result<Job> find(std::string_view id) { return jobs_.find(id); }

  /// Calls the function at every change of the job, as JobEvents does.
  std::shared_ptr<void> watch(std::string_view id, std::function<void()> wake) {
    return events_.subscribe(id, std::move(wake));
  }
  Result<JobPage> list(const JobFilter& filter, std::size_t limit, std::optional<std::int64_t> before) {
    return jobs_.list(filter, limit, before);
  }

  /// Has the mesh of a successful job made in another format, and what becomes of it; as Renditions.
  Result<std::shared_ptr<const Renditions::Order>> order_output(const Job& job, const std::string& mesh);
  std::optional<Result<Output>> made(const Renditions::Order& order) { return renditions_.made(order); }
  std::shared_ptr<void> watch(const Renditions::Order& order, std::function<void()> wake) {
    return renditions_.watch(order, std::move(wake));
  }

  struct Removal {
    /// As it is after a dismissal, as it was before a removal.
    Job job;
    bool removed = false;
  };
  Result<Removal> dismiss(std::string_view id);

  /// Queues a failed or dismissed job again; quota_exceeded if it is the caller's, and he may have no more.
  Result<Job> retry(std::string_view id, const http::Caller& caller);

  /// The output as a body to send; job_gone if it was removed meanwhile.
  Result<http::BodyStream> open_output(const Job& job, const Output& output);

  /// Reads the log of the job's latest attempt, which may be running; 0 at the end of what there is.
  Result<std::size_t> read_log(const Job& job, std::uint64_t offset, std::span<std::byte> buffer);

  /// not_ready unless jobs are taken: the store can be written, there is space, and the server is not stopping.
  Status ready();

  /// Takes no more jobs; everything else goes on.
  void drain() { draining_ = true; }

 private:
  Result<StoredInput> input_of(const Submission& submission, Upload* cloud, const http::Caller& caller,
                               std::string_view job);
  /// The job that the key has made before, if it has.
  Result<std::optional<Job>> made_before(const RequestContext& context, const std::string& fingerprint);

  JobStore& jobs_;
  ArtifactStore& artifacts_;
  CloudService& clouds_;
  Renditions& renditions_;
  JobEvents& events_;
  Scheduler& scheduler_;
  Incoming incoming_;
  std::atomic<bool> draining_ = false;
  KeysInFlight keys_;
};

}  // namespace surfaced::api
