// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "api/intake.hpp"
#include "api/job_json.hpp"
#include "api/outputs.hpp"
#include "api/request_context.hpp"
#include "api/routes.hpp"
#include "api/waiting.hpp"
#include "http/conditional.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using http::problem_response;
using http::Request;
using http::Response;

Result<JobService::Submitted> submit(Request& request, Endpoint endpoint, JobService& service,
                                     const RouteOptions& options) {
  const auto context = context_of(request);
  if (!context) return context.error();
  const auto turn = service.take_turn(*context);
  if (!turn) return turn.error();
  auto intake = take_in(request, endpoint, options.rules, service);
  if (!intake) return std::move(intake).error();
  return service.submit(intake->submission, std::move(intake->cloud), *context);
}

Response job_response(int status, const Job& job) {
  Response response = http::json_response(status, job_json(job));
  response.headers.add("Location", job_path(job.id));
  return response;
}

Response mesh_response(const Request& request, const Job& job, JobService& service) {
  const std::string& name = job.wanted.front();
  const auto output = std::ranges::find(job.outputs, name, &Output::name);
  if (output == job.outputs.end()) {
    return problem_response({ErrorCode::internal_error, "job " + job.id + " has lost its output " + name}, request);
  }
  auto body = service.open_output(job, *output);
  if (!body) return problem_response(body.error(), request);
  Response response;
  response.content_type = media_type_of(name);
  response.headers.add("ETag", "\"" + output->sha256 + "\"");
  response.headers.add("Repr-Digest", http::digest_field(output->sha256));
  response.headers.add("Content-Location", output_path(job.id, name));
  response.headers.add("Link",
                       "<" + output_path(job.id, "report.json") + ">; rel=\"describedby\"; type=\"application/json\"");
  response.headers.add("Cache-Control", "no-store");
  response.body = std::move(*body);
  return response;
}

Response reconstructed(const Request& request, const Job& job, JobService& service) {
  switch (job.status) {
    case JobStatus::successful:
      return mesh_response(request, job, service);
    case JobStatus::failed:
      return problem_response(job.error.value_or(Error{ErrorCode::internal_error, "the job failed without a reason"}),
                              request);
    case JobStatus::dismissed:
      return problem_response({ErrorCode::cancelled, "the job " + job.id + " was dismissed meanwhile"}, request);
    default:
      return job_response(202, job);
  }
}

Response reconstruct(Request& request, JobService& service, const RouteOptions& options) {
  const auto submitted = submit(request, Endpoint::reconstruct, service, options);
  if (!submitted) return problem_response(submitted.error(), request);
  // Without a permit to wait the job goes on all the same.
  auto permit = acquire_permit(request, options.waits);
  const auto wait = permit ? options.reconstruct_wait : std::chrono::milliseconds(0);
  return when_enough(
      request, submitted->job.id, wait, service, [](const Job& job) { return ended(job.status); },
      [&service](const Request& asked, const Job& job) { return reconstructed(asked, job, service); },
      permit ? std::move(*permit) : nullptr);
}

Response create_job(Request& request, JobService& service, const RouteOptions& options) {
  const auto submitted = submit(request, Endpoint::jobs, service, options);
  if (!submitted) return problem_response(submitted.error(), request);
  return job_response(submitted->replayed ? 200 : 201, submitted->job);
}

}  // namespace

void add_submit_routes(http::Router& router, JobService& service, const RouteOptions& options) {
  router.add("POST", "/v1/reconstruct",
             [&service, options](Request& request) { return reconstruct(request, service, options); });
  router.add("POST", "/v1/jobs",
             [&service, options](Request& request) { return create_job(request, service, options); });
}

}  // namespace surfaced::api
