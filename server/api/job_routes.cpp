// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/job_json.hpp"
#include "api/paging.hpp"
#include "api/routes.hpp"
#include "api/submission.hpp"
#include "api/waiting.hpp"
#include "http/conditional.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using http::problem_response;
using http::Request;
using http::Response;
using Json = nlohmann::ordered_json;

constexpr double kLongestPoll = 60;

/// Answers with the job, or 304 if the client has it as it is.
Response job_response(const Request& request, const Job& job) {
  const std::string etag = job_etag(job);
  if (!http::not_modified(request.headers, etag)) {
    Response response = http::json_response(200, job_json(job));
    response.headers.add("ETag", etag);
    return response;
  }
  Response response;
  response.status = 304;
  response.headers.add("ETag", etag);
  response.headers.add("Cache-Control", "no-store");
  return response;
}

Response get_job(const Request& request, JobService& service, const std::shared_ptr<http::Permits>& waits) {
  const auto wait = single(request.query, "wait");
  if (!wait) return problem_response(wait.error(), request);
  double seconds = 0;
  if (!wait->empty()) {
    const auto given = number_within("wait", *wait, 0, kLongestPoll);
    if (!given) return problem_response(given.error(), request);
    seconds = *given;
  }
  const auto time = std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
  // With an ETag the client waits for news; without, for the end.
  const bool for_news = request.headers.find("If-None-Match").has_value();
  const auto enough = [for_news, headers = request.headers](const Job& job) {
    return ended(job.status) || (for_news && !http::not_modified(headers, job_etag(job)));
  };
  const auto job = service.find(request.path_parts.at("id"));
  if (!job) return problem_response(job.error(), request);
  if (time.count() == 0 || enough(*job)) return job_response(request, *job);
  // Answered without a wait, a client that polls would ask again at once, and again.
  auto permit = acquire_permit(request, waits);
  if (!permit) return problem_response(permit.error(), request);
  return when_enough(request, job->id, time, service, enough, job_response, std::move(*permit));
}

Response delete_job(const Request& request, JobService& service) {
  const auto removal = service.dismiss(request.path_parts.at("id"));
  if (!removal) return problem_response(removal.error(), request);
  return http::json_response(removal->removed ? 200 : 202, job_json(removal->job));
}

Response retry_job(const Request& request, JobService& service) {
  const auto job = service.retry(request.path_parts.at("id"), request.caller);
  if (!job) return problem_response(job.error(), request);
  Response response = http::json_response(202, job_json(*job));
  response.headers.add("Location", job_path(job->id));
  return response;
}

Response list_jobs(const Request& request, JobService& service) {
  const auto asked = read_page(request);
  if (!asked) return problem_response(asked.error(), request);
  const auto page = service.list(asked->filter, asked->limit, asked->cursor);
  if (!page) return problem_response(page.error(), request);
  Json jobs = Json::array();
  for (const Job& job : page->jobs) jobs.push_back(job_json(job));
  Json body{{"jobs", std::move(jobs)}, {"links", Json::array()}};
  body["links"].push_back({{"rel", "self"}, {"href", request.path}, {"type", "application/json"}});
  std::string next;
  if (page->next) {
    next = next_page(request, *page->next);
    body["links"].push_back({{"rel", "next"}, {"href", next}, {"type", "application/json"}});
  }
  Response response = http::json_response(200, body);
  if (!next.empty()) response.headers.add("Link", "<" + next + ">; rel=\"next\"");
  return response;
}

}  // namespace

void add_job_routes(http::Router& router, JobService& service, const RouteOptions& options) {
  router.add("GET", "/v1/jobs", [&service](Request& request) { return list_jobs(request, service); });
  router.add("GET", "/v1/jobs/{id}",
             [&service, waits = options.waits](Request& request) { return get_job(request, service, waits); });
  router.add("DELETE", "/v1/jobs/{id}", [&service](Request& request) { return delete_job(request, service); });
  router.add("POST", "/v1/jobs/{id}/retry", [&service](Request& request) { return retry_job(request, service); });
}

}  // namespace surfaced::api
