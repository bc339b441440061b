#include <algorithm>
#include <functional>
#include <memory>
#include <optional>

#include "api/job_json.hpp"
#include "api/routes.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using http::problem_response;
using http::Request;
using http::Response;

constexpr double kLongestPoll = 60;

/// The body is the raw bytes of a cloud and nothing around them.
Status check_content(const Request& request) {
  if (const auto encoding = request.headers.find("Content-Encoding");
      encoding && !http::same_name(*encoding, "identity")) {
    return Error{ErrorCode::unsupported_content_encoding, "Content-Encoding is '" + std::string(*encoding) + "'"};
  }
  const std::string type(request.headers.find("Content-Type").value_or(""));
  const std::string essence = type.substr(0, type.find(';'));
  for (const std::string_view wrapped : {"application/json", "multipart/form-data"}) {
    if (http::same_name(essence, wrapped)) {
      return Error{ErrorCode::invalid_request,
                   "Content-Type is '" + essence + "'; this version takes the raw bytes of a cloud as the body"};
    }
  }
  return Done{};
}

/// The trace context, if it is one by the letter of the W3C: 00-TRACE-SPAN-FLAGS in lower-case hexadecimal.
std::string traceparent_of(const Request& request) {
  const std::string value(request.headers.find("traceparent").value_or(""));
  constexpr std::string_view kShape = "00-xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx-xxxxxxxxxxxxxxxx-xx";
  const bool fits = value.size() == kShape.size() && std::ranges::equal(value, kShape, [](char given, char shape) {
                      if (shape != 'x') return given == shape;
                      return (given >= '0' && given <= '9') || (given >= 'a' && given <= 'f');
                    });
  return fits ? value : std::string();
}

Result<Job> submit(Request& request, Door door, JobService& service, const RouteOptions& options) {
  if (Status content = check_content(request); !content.ok()) return content.error();
  const auto submission = read_submission(request.query, door, options.ttl);
  if (!submission) return submission.error();
  return service.submit(*submission, *request.body, {request.request_id, traceparent_of(request)});
}

Response created(int status, const Job& job) {
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
  response.headers.add("Content-Location", output_path(job.id, name));
  response.headers.add("Link",
                       "<" + output_path(job.id, "report.json") + ">; rel=\"describedby\"; type=\"application/json\"");
  response.headers.add("Cache-Control", "no-store");
  response.body = std::move(*body);
  return response;
}

/// The answer to a request that waits for the job's end: what `show` makes of the job when it has ended or the
/// time is over.
Response when_ended(const Request& request, const std::string& id, std::chrono::milliseconds at_most,
                    JobService& service, std::function<Response(const Request&, const Job&)> show) {
  Request asked = request;
  asked.body = nullptr;
  auto later = std::make_shared<http::Later>();
  later->deadline = std::chrono::steady_clock::now() + at_most;
  later->subscribe = [&service, id](std::function<void()> wake) { return service.watch(id, std::move(wake)); };
  later->look = [&service, id, asked = std::move(asked), show = std::move(show)](bool last) -> std::optional<Response> {
    const auto job = service.find(id);
    if (!job) return problem_response(job.error(), asked);
    if (!last && !ended(job->status)) return std::nullopt;
    return show(asked, *job);
  };
  Response response;
  response.later = std::move(later);
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
      return created(202, job);
  }
}

Response reconstruct(Request& request, JobService& service, const RouteOptions& options) {
  const auto submitted = submit(request, Door::reconstruct, service, options);
  if (!submitted) return problem_response(submitted.error(), request);
  return when_ended(request, submitted->id, options.reconstruct_wait, service,
                    [&service](const Request& asked, const Job& job) { return reconstructed(asked, job, service); });
}

Response get_job(const Request& request, JobService& service) {
  const auto wait = single(request.query, "wait");
  if (!wait) return problem_response(wait.error(), request);
  double seconds = 0;
  if (!wait->empty()) {
    const auto given = number_within("wait", *wait, 0, kLongestPoll);
    if (!given) return problem_response(given.error(), request);
    seconds = *given;
  }
  const auto time = std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
  return when_ended(request, request.path_parts.at("id"), time, service,
                    [](const Request&, const Job& job) { return http::json_response(200, job_json(job)); });
}

Response delete_job(const Request& request, JobService& service) {
  const auto removal = service.dismiss(request.path_parts.at("id"));
  if (!removal) return problem_response(removal.error(), request);
  return http::json_response(removal->removed ? 200 : 202, job_json(removal->job));
}

Response retry_job(const Request& request, JobService& service) {
  const auto job = service.retry(request.path_parts.at("id"));
  return job ? created(202, *job) : problem_response(job.error(), request);
}

}  // namespace

void add_job_routes(http::Router& router, JobService& service, const RouteOptions& options) {
  router.add("POST", "/v1/reconstruct",
             [&service, options](Request& request) { return reconstruct(request, service, options); });
  router.add("POST", "/v1/jobs", [&service, options](Request& request) {
    const auto job = submit(request, Door::jobs, service, options);
    return job ? created(201, *job) : problem_response(job.error(), request);
  });
  router.add("GET", "/v1/jobs/{id}", [&service](Request& request) { return get_job(request, service); });
  router.add("POST", "/v1/jobs/{id}/retry", [&service](Request& request) { return retry_job(request, service); });
  router.add("DELETE", "/v1/jobs/{id}", [&service](Request& request) { return delete_job(request, service); });
}

}  // namespace surfaced::api
