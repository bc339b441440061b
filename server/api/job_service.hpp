#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

#include "api/submission.hpp"
#include "artifacts/artifact_store.hpp"
#include "http/message.hpp"
#include "jobs/job_events.hpp"
#include "jobs/job_store.hpp"
#include "jobs/scheduler.hpp"

namespace surfaced::api {

/// By what a job is found again in logs and traces.
struct RequestMark {
  std::string request_id;
  std::string traceparent;
};

/// What the doors of the service do with jobs: take one in, wait for one, end one. Knows stores and
/// scheduler, not how answers look.
class JobService {
 public:
  /// @param waiters  requests that may wait for a job at once; more are answered with the state as it is,
  ///                 so that waiting can never take all connections
  JobService(JobStore& jobs, ArtifactStore& artifacts, JobEvents& events, Scheduler& scheduler, std::size_t waiters);

  /// Stores the body and queues a job; durable when the call returns.
  /// @return  length_required, empty_input, queue_full, storage_full, and what reading the body may say.
  Result<Job> submit(const Submission& submission, http::BodySource& body, const RequestMark& mark);

  Result<Job> find(std::string_view id) { return jobs_.find(id); }

  /// The job when it has ended, or as it is when the time is over.
  Result<Job> wait(std::string_view id, std::chrono::milliseconds at_most);

  struct Removal {
    /// As it is after a dismissal, as it was before a removal.
    Job job;
    bool removed = false;
  };
  Result<Removal> dismiss(std::string_view id);

  /// Queues a failed or dismissed job again.
  Result<Job> retry(std::string_view id);

  /// The output as a body to send; job_gone if it was removed meanwhile.
  Result<http::BodyStream> open_output(const Job& job, const Output& output);

  Status ready();

 private:
  Result<StoredInput> store_body(http::BodySource& body, std::string_view key);

  JobStore& jobs_;
  ArtifactStore& artifacts_;
  JobEvents& events_;
  Scheduler& scheduler_;
  std::atomic<std::ptrdiff_t> free_waiters_;
};

}  // namespace surfaced::api
