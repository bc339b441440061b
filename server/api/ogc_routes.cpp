// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "api/intake.hpp"
#include "api/job_json.hpp"
#include "api/ogc_json.hpp"
#include "api/ogc_results.hpp"
#include "api/outputs.hpp"
#include "api/paging.hpp"
#include "api/request_context.hpp"
#include "api/routes.hpp"
#include "api/waiting.hpp"
#include "http/assembly.hpp"
#include "http/problem.hpp"
#include "platform/files.hpp"
#include "proto/embedded.hpp"

namespace surfaced::api {
namespace {

using http::json_response;
using http::Request;
using http::Response;
using ogc::Json;

/// A cloud inside JSON is for trying things out; the other ways in have no such limit.
constexpr std::size_t kMaxExecution = std::size_t{16} << 20;

Result<const MethodInfo*> method_of(const Request& request) {
  auto method = find_method(request.path_parts.at("id"));
  if (method) return method;
  return Error{ErrorCode::method_not_found, method.error().detail, method.error().fault};
}

/// The page of processes that limit and offset choose; offset is ours, and stands in the link to the next page.
Response list_processes(const Request& request) {
  constexpr double kMostProcesses = 10'000;
  const auto number = [&](std::string_view name, double least) -> Result<std::optional<std::size_t>> {
    const auto text = single(request.query, name);
    if (!text) return text.error();
    if (text->empty()) return std::optional<std::size_t>();
    const auto value = number_within(name, *text, least, kMostProcesses);
    if (!value) return value.error();
    return std::optional(static_cast<std::size_t>(*value));
  };
  const auto limit = number("limit", 1);
  if (!limit) return ogc::problem(limit.error(), request);
  const auto offset = number("offset", 0);
  if (!offset) return ogc::problem(offset.error(), request);
  const std::size_t begin = std::min(offset->value_or(0), methods().size());
  const std::size_t count = std::min(limit->value_or(methods().size()), methods().size() - begin);
  Json processes = Json::array();
  for (const MethodInfo& method : methods().subspan(begin, count)) processes.push_back(ogc::process_summary(method));
  Json links = Json::array({{{"rel", "self"}, {"href", "/processes"}, {"type", "application/json"}}});
  if (begin + count < methods().size()) {
    const std::string next = "/processes?limit=" + std::to_string(count) + "&offset=" + std::to_string(begin + count);
    links.push_back({{"rel", "next"}, {"href", next}, {"type", "application/json"}});
  }
  return json_response(200, {{"processes", std::move(processes)}, {"links", std::move(links)}});
}

Response get_process(const Request& request) {
  const auto method = method_of(request);
  return method ? json_response(200, ogc::process_description(**method)) : ogc::problem(method.error(), request);
}

struct Preference {
  bool async = false;
  std::optional<std::chrono::seconds> wait;
};
Preference preference_of(const Request& request) {
  Preference preference;
  constexpr std::string_view kWait = "wait=";
  for (const auto& [name, value] : request.headers) {
    if (!http::same_name(name, "Prefer")) continue;
    for (const std::string& entry : split_list(value)) {
      std::string_view one = entry;
      one = one.substr(0, one.find(';'));
      while (one.starts_with(' ')) one.remove_prefix(1);
      while (one.ends_with(' ')) one.remove_suffix(1);
      if (http::same_name(one, "respond-async")) preference.async = true;
      if (!http::same_name(one.substr(0, kWait.size()), kWait)) continue;
      // What cannot be read is no preference (RFC 7240 §2).
      const auto seconds = number_within("wait", one.substr(kWait.size()), 0, 60);
      if (seconds) preference.wait = std::chrono::seconds(static_cast<std::int64_t>(*seconds));
    }
  }
  return preference;
}

Response status_response(int status, const Job& job) {
  Response response = json_response(status, ogc::status_info(job));
  if (status == 201) response.headers.add("Location", "/jobs/" + job.id);
  return response;
}

/// Why a job has no results; none for one that has.
std::optional<Error> no_results(const Job& job) {
  if (job.status == JobStatus::successful) return std::nullopt;
  if (job.status == JobStatus::failed && job.error) return job.error;
  if (!ended(job.status)) {
    return Error{ErrorCode::result_not_ready, "job " + job.id + " is " + std::string(name_of(job.status))};
  }
  return Error{ErrorCode::job_not_successful, "job " + job.id + " is " + std::string(name_of(job.status))};
}

Result<JobService::Submitted> submit(const ogc::Execution& execution, const RequestContext& context,
                                     JobService& service, const RouteOptions& options) {
  auto submission = read_submission(execution.submission, options.rules);
  if (!submission) return std::move(submission).error();
  submission->presentation = ogc::text_of(execution.presentation);
  std::unique_ptr<Upload> cloud;
  if (!execution.cloud.empty()) {
    auto upload = service.begin_upload(context.caller, execution.cloud.size());
    if (!upload) return std::move(upload).error();
    cloud = std::move(*upload);
    if (Status written = cloud->write(as_bytes(execution.cloud)); !written.ok()) return written.error();
  }
  return service.submit(*submission, std::move(cloud), context);
}

Response execute(Request& request, JobService& service, const RouteOptions& options) {
  const auto method = method_of(request);
  if (!method) return ogc::problem(method.error(), request);
  const auto context = context_of(request);
  if (!context) return ogc::problem(context.error(), request);
  const auto turn = service.take_turn(*context);
  if (!turn) return ogc::problem(turn.error(), request);
  const auto body = receive_json(request, kMaxExecution);
  if (!body) return ogc::problem(body.error(), request);
  const auto execution = ogc::read_execution(*body, **method);
  if (!execution) return ogc::problem(execution.error(), request);
  const auto submitted = submit(*execution, *context, service, options);
  if (!submitted) return ogc::problem(submitted.error(), request);
  const Preference preference = preference_of(request);
  if (preference.async && !preference.wait) {
    Response response = status_response(201, submitted->job);
    response.headers.add("Preference-Applied", "respond-async");
    return response;
  }
  // Without a permit to wait the job goes on all the same.
  auto permit = acquire_permit(request, options.waits);
  const std::chrono::milliseconds wait =
      permit ? preference.wait.value_or(std::chrono::duration_cast<std::chrono::seconds>(options.reconstruct_wait))
             : std::chrono::seconds(0);
  return when_enough(
      request, submitted->job.id, wait, service, [](const Job& job) { return ended(job.status); },
      [&service](const Request& asked, const Job& job) {
        if (!ended(job.status)) return status_response(201, job);
        if (const auto error = no_results(job)) return ogc::problem(*error, asked);
        return ogc::results(asked, job, service);
      },
      permit ? std::move(*permit) : nullptr);
}

Response list_ogc_jobs(const Request& request, JobService& service) {
  const auto page = read_ogc_page(request);
  if (!page) return ogc::problem(page.error(), request);
  const auto found = service.list(page->filter, page->limit, page->cursor);
  if (!found) return ogc::problem(found.error(), request);
  Json jobs = Json::array();
  for (const Job& job : found->jobs) jobs.push_back(ogc::status_info(job));
  Json links = Json::array({{{"rel", "self"}, {"href", "/jobs"}, {"type", "application/json"}}});
  if (found->next) {
    links.push_back({{"rel", "next"}, {"href", next_page(request, *found->next)}, {"type", "application/json"}});
  }
  return json_response(200, {{"jobs", std::move(jobs)}, {"links", std::move(links)}});
}

Response get_results(const Request& request, JobService& service) {
  const auto job = service.find(request.path_parts.at("id"));
  if (!job) return ogc::problem(job.error(), request);
  if (const auto error = no_results(*job)) return ogc::problem(*error, request);
  return ogc::results(request, *job, service);
}

Response dismiss(const Request& request, JobService& service) {
  const auto removal = service.dismiss(request.path_parts.at("id"));
  if (!removal) return ogc::problem(removal.error(), request);
  Json info = ogc::status_info(removal->job);
  info["status"] = name_of(JobStatus::dismissed);
  return json_response(200, info);
}

}  // namespace

void add_ogc_routes(http::Router& router, JobService& service, const RouteOptions& options) {
  router.add("GET", "/conformance", [](Request&) { return json_response(200, ogc::conformance()); });
  router.add("GET", "/processes", list_processes);
  router.add("GET", "/processes/{id}", get_process);
  router.add("POST", "/processes/{id}/execution",
             [&service, options](Request& request) { return execute(request, service, options); });
  router.add("GET", "/jobs", [&service](Request& request) { return list_ogc_jobs(request, service); });
  router.add("GET", "/jobs/{id}", [&service](Request& request) {
    const auto job = service.find(request.path_parts.at("id"));
    return job ? status_response(200, *job) : ogc::problem(job.error(), request);
  });
  router.add("GET", "/jobs/{id}/results", [&service](Request& request) { return get_results(request, service); });
  router.add("DELETE", "/jobs/{id}", [&service](Request& request) { return dismiss(request, service); });
  router.add("GET", "/openapi-3.0.json", [](Request&) {
    Response response;
    response.content_type = "application/vnd.oai.openapi+json;version=3.0";
    response.body = http::body_of_static(proto::openapi30_json());
    return response;
  });
}

}  // namespace surfaced::api
