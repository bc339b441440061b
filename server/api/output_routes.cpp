#include <algorithm>

#include "api/job_json.hpp"
#include "api/outputs.hpp"
#include "api/routes.hpp"
#include "http/conditional.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using http::problem_response;
using http::Request;
using http::Response;

/// The mesh in the format that Accept chooses.
constexpr std::string_view kAnyMesh = "mesh";

/// The output of this name, made now if it is a mesh in a format that nobody has asked for yet; or why there is none.
Result<Output> find_output(const Job& job, const std::string& name, JobService& service) {
  const auto found = std::ranges::find(job.outputs, name, &Output::name);
  if (found != job.outputs.end()) return *found;
  const std::string subject = "job " + job.id + " is " + std::string(name_of(job.status));
  if (media_type_of(name).empty()) {
    return with_fault({ErrorCode::output_not_found, "no job has an output '" + name + "'"},
                      {"name", name, "mesh, mesh.FORMAT, cloud.ply, report.json, log.txt"});
  }
  if (!ended(job.status)) return Error{ErrorCode::not_finished, subject + " and has no " + name + " yet"};
  if (job.status != JobStatus::successful) return Error{ErrorCode::job_not_successful, subject + " and has no " + name};
  if (is_mesh(name)) return service.make_output(job, name);
  std::string made;
  for (const Output& output : job.outputs) made += (made.empty() ? "" : ", ") + output.name;
  return with_fault({ErrorCode::output_not_found, "job " + job.id + " has no " + name + "; it made " + made},
                    {"name", name, "one of " + made});
}

/// The name to look for: the one asked for, or that of the format that the client wants most.
Result<std::string> wanted_name(const Request& request, const Job& job) {
  const std::string& name = request.path_parts.at("name");
  if (name != kAnyMesh) return name;
  std::vector<std::string> made;
  for (const Output& output : job.outputs) made.push_back(output.name);
  return negotiate_mesh(request.headers.find("Accept"), made);
}

Response get_output(const Request& request, JobService& service) {
  const auto job = service.find(request.path_parts.at("id"));
  if (!job) return problem_response(job.error(), request);
  const auto name = wanted_name(request, *job);
  if (!name) return problem_response(name.error(), request);
  const auto output = find_output(*job, *name, service);
  if (!output) return problem_response(output.error(), request);
  auto body = service.open_output(*job, *output);
  if (!body) return problem_response(body.error(), request);
  Response response = http::conditional_response(request, "\"" + output->sha256 + "\"",
                                                 std::string(media_type_of(*name)), std::move(*body));
  if (response.status < 400) response.headers.add("Repr-Digest", http::digest_field(output->sha256));
  if (*name != request.path_parts.at("name")) {
    response.headers.add("Vary", "Accept");
    response.headers.add("Content-Location", output_path(job->id, *name));
  }
  return response;
}

}  // namespace

void add_output_routes(http::Router& router, JobService& service) {
  router.add("GET", "/v1/jobs/{id}/outputs/{name}",
             [&service](Request& request) { return get_output(request, service); });
}

}  // namespace surfaced::api
