// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/job_service.hpp"

#include <algorithm>
#include <memory>

#include "api/outputs.hpp"
#include "base/sha256.hpp"
#include "platform/files.hpp"
#include "platform/random.hpp"

namespace surfaced::api {
namespace {

/// Hash of everything that a submission asks for.
std::string fingerprint_of(const Submission& submission, const std::string& input_sha256) {
  nlohmann::ordered_json all{
      {"method", submission.method}, {"parameters", submission.parameters}, {"outputs", submission.outputs},
      {"labels", submission.labels}, {"ttl", submission.ttl.count()},       {"webhook", submission.webhook},
      {"input", input_sha256},
  };
  if (!submission.presentation.empty()) all["presentation"] = submission.presentation;
  Sha256 sha;
  sha.update(as_bytes(all.dump()));
  return sha.finish();
}

}  // namespace

KeysInFlight::Turn::~Turn() {
  if (keys_ == nullptr) return;
  const std::scoped_lock lock(keys_->mutex_);
  keys_->held_.erase(entry_);
}

Result<KeysInFlight::Turn> KeysInFlight::take(const RequestContext& context) {
  if (context.idempotency_key.empty()) return Turn();
  std::string entry = context.caller.id + "\n" + context.idempotency_key;
  const std::scoped_lock lock(mutex_);
  if (held_.insert(entry).second) return Turn(*this, std::move(entry));
  return with_fault({ErrorCode::request_in_flight,
                     "another request with the Idempotency-Key '" + context.idempotency_key + "' has no answer yet"},
                    {"Idempotency-Key", context.idempotency_key, "the same request, once the first has its answer"});
}

JobService::JobService(JobStore& jobs, ArtifactStore& artifacts, CloudService& clouds, Renditions& renditions,
                       JobEvents& events, Scheduler& scheduler)
    : jobs_(jobs),
      artifacts_(artifacts),
      clouds_(clouds),
      renditions_(renditions),
      events_(events),
      scheduler_(scheduler),
      incoming_(jobs) {}

Result<std::unique_ptr<Upload>> JobService::begin_upload(const http::Caller& caller, std::uint64_t needed) {
  if (draining_) return Error{ErrorCode::not_ready, "the server is stopping"};
  if (Status space = artifacts_.check_space(needed); !space.ok()) return space.error();
  auto upload = artifacts_.begin_upload();
  if (!upload) return upload;
  return incoming_.count(std::move(*upload), caller, needed);
}

Result<JobService::Submitted> JobService::submit(const Submission& submission, std::unique_ptr<Upload> cloud,
                                                 const RequestContext& context) {
  const std::string fingerprint = fingerprint_of(submission, cloud ? cloud->sha256() : submission.cloud_id);
  auto before = made_before(context, fingerprint);
  if (!before) return std::move(before).error();
  if (before->has_value()) return Submitted{std::move(**before), true};
  if (draining_) return Error{ErrorCode::not_ready, "the server is stopping"};
  if (Status room = jobs_.check_room(); !room.ok()) return room.error();
  const std::string id = random_hex<16>();
  const auto input = input_of(submission, cloud.get(), context.caller, id);
  if (!input) return input.error();
  const NewJob job{id,
                   submission.method,
                   submission.parameters,
                   *input,
                   submission.outputs,
                   context.request_id,
                   context.traceparent,
                   submission.ttl,
                   context.caller.id,
                   submission.labels,
                   submission.webhook,
                   context.idempotency_key,
                   fingerprint,
                   submission.presentation};
  auto stored = jobs_.submit(job, allowance_of(context.caller));
  if (stored) {
    scheduler_.wake();
    return Submitted{std::move(*stored), false};
  }
  const ErrorCode why = stored.error().code;
  const bool refused = why == ErrorCode::queue_full || why == ErrorCode::quota_exceeded;
  if (refused && cloud) artifacts_.remove({{job.input.key}, {}});
  // After any other failure it is not known whether the store has the job: its input stays, and the
  // sweep at the next start decides.
  return stored.error();
}

Result<StoredInput> JobService::input_of(const Submission& submission, Upload* cloud, const http::Caller& caller,
                                         std::string_view job) {
  if (cloud != nullptr) return cloud->commit(job);
  const auto stored = clouds_.find(submission.cloud_id, caller.owner());
  if (!stored) return stored.error();
  return StoredInput{stored->id, stored->bytes, stored->id};
}

Result<std::optional<Job>> JobService::made_before(const RequestContext& context, const std::string& fingerprint) {
  if (context.idempotency_key.empty()) return std::optional<Job>();
  const auto replay = jobs_.replay(context.caller.id, context.idempotency_key);
  if (!replay) return replay.error();
  if (!replay->has_value()) return std::optional<Job>();
  if ((*replay)->fingerprint != fingerprint) {
    return with_fault(
        {ErrorCode::idempotency_mismatch, "the Idempotency-Key '" + context.idempotency_key + "' has made the job " +
                                              (*replay)->job + " from another cloud or with other parameters"},
        {"Idempotency-Key", context.idempotency_key, "a key that was not used, or the same request again"});
  }
  auto job = jobs_.find((*replay)->job);
  if (!job) return std::move(job).error();
  return std::optional(std::move(*job));
}

Result<std::shared_ptr<const Renditions::Order>> JobService::order_output(const Job& job, const std::string& mesh) {
  const auto kinds = mesh_kinds();
  const auto kind = std::ranges::find(kinds, mesh, &OutputKind::name);
  return renditions_.order(job, mesh, static_cast<std::uint32_t>(kind - kinds.begin()));
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

Result<Job> JobService::retry(std::string_view id, const http::Caller& caller) {
  const auto owner = jobs_.owner_of(id);
  if (!owner) return owner.error();
  auto retried = jobs_.retry(id, *owner == caller.id ? allowance_of(caller) : Allowance{});
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

Result<std::size_t> JobService::read_log(const Job& job, std::uint64_t offset, std::span<std::byte> buffer) {
  const auto reader = artifacts_.open_log({job.id, job.attempt});
  if (!reader) return reader.error();
  return (*reader)->read(offset, buffer);
}

Status JobService::ready() {
  if (draining_) return Error{ErrorCode::not_ready, "the server is stopping"};
  if (Status space = artifacts_.check_space(0); !space.ok()) return space;
  return jobs_.writable();
}

}  // namespace surfaced::api
