#include <algorithm>

#include "api/job_json.hpp"
#include "api/routes.hpp"
#include "api/submission.hpp"
#include "http/conditional.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using http::Request;
using http::Response;

/// The committed output of this name, or why there is none.
Result<Output> find_output(const Job& job, const std::string& name) {
  const auto found = std::ranges::find(job.outputs, name, &Output::name);
  if (found != job.outputs.end()) return *found;
  const std::string subject = "job " + job.id + " is " + std::string(name_of(job.status));
  if (media_type_of(name).empty()) return Error{ErrorCode::output_not_found, "no job has an output '" + name + "'"};
  if (!ended(job.status)) return Error{ErrorCode::not_finished, subject + " and has no " + name + " yet"};
  if (job.status != JobStatus::successful) return Error{ErrorCode::job_not_successful, subject + " and has no " + name};
  std::string made;
  for (const Output& output : job.outputs) made += (made.empty() ? "" : ", ") + output.name;
  return Error{ErrorCode::output_not_found, "job " + job.id + " has no " + name + "; it made " + made};
}

Response get_output(const Request& request, JobService& service) {
  const std::string& name = request.path_parts.at("name");
  const auto job = service.find(request.path_parts.at("id"));
  if (!job) return problem_response(job.error(), request);
  const auto output = find_output(*job, name);
  if (!output) return problem_response(output.error(), request);
  auto body = service.open_output(*job, *output);
  if (!body) return problem_response(body.error(), request);
  return http::conditional_response(request, "\"" + output->sha256 + "\"", std::string(media_type_of(name)),
                                    std::move(*body));
}

}  // namespace

void add_output_routes(http::Router& router, JobService& service) {
  router.add("GET", "/v1/jobs/{id}/outputs/{name}",
             [&service](Request& request) { return get_output(request, service); });
}

}  // namespace surfaced::api
