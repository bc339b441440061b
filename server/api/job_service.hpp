#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

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
  JobService(JobStore& jobs, ArtifactStore& artifacts, JobEvents& events, Scheduler& scheduler);

  /// Stores the body and queues a job; durable when the call returns.
  /// @return  length_required, empty_input, queue_full, storage_full, and what reading the body may say.
  Result<Job> submit(const Submission& submission, http::BodySource& body, const RequestMark& mark);

  Result<Job> find(std::string_view id) { return jobs_.find(id); }

  /// Calls the function at every change of the job, as JobEvents does.
  std::shared_ptr<void> watch(std::string_view id, std::function<void()> wake) {
    return events_.subscribe(id, std::move(wake));
  }

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

  /// not_ready unless jobs are taken: the store can be written, there is space, and the server is not stopping.
  Status ready();

  /// Takes no more jobs; everything else goes on.
  void drain() { draining_ = true; }

 private:
  Result<StoredInput> store_body(http::BodySource& body, std::string_view key);

  JobStore& jobs_;
  ArtifactStore& artifacts_;
  JobEvents& events_;
  Scheduler& scheduler_;
  std::atomic<bool> draining_ = false;
};

}  // namespace surfaced::api
