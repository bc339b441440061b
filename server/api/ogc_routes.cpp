#include <algorithm>

#include "api/intake.hpp"
#include "api/job_json.hpp"
#include "api/mark.hpp"
#include "api/ogc_json.hpp"
#include "api/outputs.hpp"
#include "api/paging.hpp"
#include "api/routes.hpp"
#include "api/waiting.hpp"
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
  return Error{ErrorCode::method_not_found, method.error().detail};
}

Response list_processes(const Request& /*request*/) {
  Json processes = Json::array();
  for (const MethodInfo& method : methods()) processes.push_back(ogc::process_summary(method));
  return json_response(200, {{"processes", std::move(processes)},
                             {"links", {{{"rel", "self"}, {"href", "/processes"}, {"type", "application/json"}}}}});
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
  std::string_view list = request.headers.find("Prefer").value_or("");
  while (!list.empty()) {
    std::string_view one = list.substr(0, list.find(','));
    list.remove_prefix(std::min(list.size(), one.size() + 1));
    while (one.starts_with(' ')) one.remove_prefix(1);
    if (one == "respond-async") preference.async = true;
    if (one.starts_with("wait=")) {
      const auto seconds = number_within("wait", one.substr(5), 0, 60);
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

/// One output as such.
Response raw_output(const Request& request, const Job& job, const std::string& name, JobService& service) {
  const auto output = std::ranges::find(job.outputs, name, &Output::name);
  if (output == job.outputs.end()) {
    return ogc::problem({ErrorCode::internal_error, "job " + job.id + " has lost its output " + name}, request);
  }
  auto body = service.open_output(job, *output);
  if (!body) return ogc::problem(body.error(), request);
  Response response;
  response.content_type = media_type_of(name);
  response.headers.add("Link", "<" + output_path(job.id, "report.json") + ">; rel=\"describedby\"");
  response.headers.add("Cache-Control", "no-store");
  response.body = std::move(*body);
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

Result<JobService::Submitted> submit(const ogc::Execution& execution, const RequestMark& mark, JobService& service,
                                     const RouteOptions& options) {
  auto submission = read_submission(execution.submission, options.rules);
  if (!submission) return std::move(submission).error();
  std::unique_ptr<Upload> cloud;
  if (!execution.cloud.empty()) {
    auto upload = service.begin_upload();
    if (!upload) return std::move(upload).error();
    cloud = std::move(*upload);
    if (Status written = cloud->write(as_bytes(execution.cloud)); !written.ok()) return written.error();
  }
  return service.submit(*submission, std::move(cloud), mark);
}

Response execute(Request& request, JobService& service, const RouteOptions& options) {
  const auto method = method_of(request);
  if (!method) return ogc::problem(method.error(), request);
  const auto mark = mark_of(request);
  if (!mark) return ogc::problem(mark.error(), request);
  const auto turn = service.take_turn(*mark);
  if (!turn) return ogc::problem(turn.error(), request);
  const auto body = receive_json(request, kMaxExecution);
  if (!body) return ogc::problem(body.error(), request);
  const auto execution = ogc::read_execution(*body, **method);
  if (!execution) return ogc::problem(execution.error(), request);
  const auto submitted = submit(*execution, *mark, service, options);
  if (!submitted) return ogc::problem(submitted.error(), request);
  const Preference preference = preference_of(request);
  if (preference.async && !preference.wait) {
    Response response = status_response(201, submitted->job);
    response.headers.add("Preference-Applied", "respond-async");
    return response;
  }
  const std::chrono::milliseconds wait =
      preference.wait.value_or(std::chrono::duration_cast<std::chrono::seconds>(options.reconstruct_wait));
  const std::string output = execution->report_alone ? "report.json" : submitted->job.wanted.front();
  return when_enough(
      request, submitted->job.id, wait, service, [](const Job& job) { return ended(job.status); },
      [&service, raw = execution->raw, output](const Request& asked, const Job& job) {
        if (!ended(job.status)) return status_response(201, job);
        if (const auto error = no_results(job)) return ogc::problem(*error, asked);
        return raw ? raw_output(asked, job, output, service) : json_response(200, ogc::results(job));
      });
}

Response list_jobs(const Request& request, JobService& service) {
  const auto page = read_page(request, {"type", "processID"});
  if (!page) return ogc::problem(page.error(), request);
  JobFilter filter = page->filter;
  const auto process = single(request.query, "processID");
  if (!process) return ogc::problem(process.error(), request);
  if (!process->empty()) filter.method = *process;
  const auto found = service.list(filter, page->limit, page->cursor);
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
  return json_response(200, ogc::results(*job));
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
  router.add("GET", "/jobs", [&service](Request& request) { return list_jobs(request, service); });
  router.add("GET", "/jobs/{id}", [&service](Request& request) {
    const auto job = service.find(request.path_parts.at("id"));
    return job ? status_response(200, *job) : ogc::problem(job.error(), request);
  });
  router.add("GET", "/jobs/{id}/results", [&service](Request& request) { return get_results(request, service); });
  router.add("DELETE", "/jobs/{id}", [&service](Request& request) { return dismiss(request, service); });
  router.add("GET", "/openapi-3.0.json", [](Request&) {
    Response response;
    response.content_type = "application/vnd.oai.openapi+json;version=3.0";
    response.body = std::string(proto::openapi30_json());
    return response;
  });
}

}  // namespace surfaced::api
