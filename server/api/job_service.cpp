#include "api/job_service.hpp"

#include <memory>

#include "platform/random.hpp"

namespace surfaced::api {
JobService::JobService(JobStore& jobs, ArtifactStore& artifacts, JobEvents& events, Scheduler& scheduler)
    : jobs_(jobs), artifacts_(artifacts), events_(events), scheduler_(scheduler) {}

Result<Job> JobService::submit(const Submission& submission, http::BodySource& body, const RequestMark& mark) {
  if (!body.present()) {
    return Error{ErrorCode::length_required, "the request has neither Content-Length nor Transfer-Encoding"};
  }
  if (body.length() == 0) return Error{ErrorCode::empty_input, "the body has 0 bytes"};
  if (draining_) return Error{ErrorCode::not_ready, "the server is stopping"};
  if (Status room = jobs_.check_room(); !room.ok()) return room.error();
  if (Status space = artifacts_.check_space(body.length().value_or(0)); !space.ok()) return space.error();
  const std::string id = random_hex<16>();
  const auto input = store_body(body, id);
  if (!input) return input.error();
  const NewJob job{id,
                   submission.method,
                   submission.parameters,
                   *input,
                   submission.outputs,
                   mark.request_id,
                   mark.traceparent,
                   submission.ttl};
  auto stored = jobs_.submit(job);
  if (stored) {
    scheduler_.wake();
  } else if (stored.error().code == ErrorCode::queue_full) {
    artifacts_.remove({{job.input.key}, {}});
  }
  // After any other failure it is not known whether the store has the job: its input stays, and the
  // sweep at the next start decides.
  return stored;
}

Result<StoredInput> JobService::store_body(http::BodySource& body, std::string_view key) {
  auto upload = artifacts_.begin_upload();
  if (!upload) return upload.error();
  const Status read = body.read([&](std::span<const std::byte> bytes) { return (*upload)->write(bytes); });
  if (!read) return read.error();
  if ((*upload)->bytes() == 0) return Error{ErrorCode::empty_input, "the body has 0 bytes"};
  return (*upload)->commit(key);
}

Result<JobService::Removal> JobService::dismiss(std::string_view id) {
  auto before = jobs_.find(id);
  if (!before) return before.error();
  const auto dismissal = jobs_.dismiss(id);
  if (!dismissal) return dismissal.error();
  events_.changed(id);
  if (dismissal->removed) {
    artifacts_.remove(dismissal->garbage);
    return Removal{std::move(*before), true};
  }
  scheduler_.cancel(id);
  auto after = jobs_.find(id);
  if (!after) return after.error();
  return Removal{std::move(*after), false};
}

Result<Job> JobService::retry(std::string_view id) {
  auto retried = jobs_.retry(id);
  if (!retried) return retried.error();
  artifacts_.remove(retried->garbage);
  events_.changed(id);
  scheduler_.wake();
  return std::move(retried->job);
}

Result<http::BodyStream> JobService::open_output(const Job& job, const Output& output) {
  auto reader = artifacts_.open_output({job.id, output.attempt}, output.name);
  if (!reader) {
    const auto now = jobs_.find(job.id);
    return now ? reader.error() : now.error();
  }
  const std::shared_ptr<OutputReader> shared = std::move(*reader);
  return http::BodyStream{shared->size(), [shared](std::uint64_t offset, std::span<std::byte> buffer) {
                            return shared->read(offset, buffer);
                          }};
}

Status JobService::ready() {
  if (draining_) return Error{ErrorCode::not_ready, "the server is stopping"};
  if (Status space = artifacts_.check_space(0); !space.ok()) return space;
  return jobs_.writable();
}

}  // namespace surfaced::api
