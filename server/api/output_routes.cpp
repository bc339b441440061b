// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include "api/job_json.hpp"
#include "api/outputs.hpp"
#include "api/routes.hpp"
#include "api/waiting.hpp"
#include "base/text.hpp"
#include "http/conditional.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using http::problem_response;
using http::Request;
using http::Response;

/// The mesh in the format that Accept chooses.
constexpr std::string_view kAnyMesh = "mesh";

/// How long a request waits for a mesh that is made in another format.
constexpr std::chrono::seconds kPatience{120};

/// The output of this name; none if it is a mesh in a format that nobody has asked for yet; or why there is none.
Result<std::optional<Output>> find_output(const Job& job, const std::string& name) {
  if (media_type_of(name).empty()) {
    return with_fault({ErrorCode::output_not_found, "no job has an output '" + name + "'"},
                      {"name", name, "mesh, mesh.FORMAT, cloud.ply, report.json, log.txt"});
  }
  const auto found = std::ranges::find(job.outputs, name, &Output::name);
  if (found != job.outputs.end()) return std::optional(*found);
  const std::string subject = "job " + job.id + " is " + std::string(name_of(job.status));
  if (!ended(job.status)) return Error{ErrorCode::not_finished, subject + " and has no " + name + " yet"};
  if (job.status != JobStatus::successful) return Error{ErrorCode::job_not_successful, subject + " and has no " + name};
  if (is_mesh(name)) return std::optional<Output>();
  std::vector<std::string> outputs;
  for (const Output& each : job.outputs) {
    if (!media_type_of(each.name).empty()) outputs.push_back(each.name);
  }
  const std::string made = joined(outputs);
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

Response output_response(const Request& request, const Job& job, const std::string& name, const Output& output,
                         JobService& service) {
  auto body = service.open_output(job, output);
  if (!body) return problem_response(body.error(), request);
  Response response = http::conditional_response(request, "\"" + output.sha256 + "\"", std::string(media_type_of(name)),
                                                 std::move(*body));
  if (response.status < 400) response.headers.add("Repr-Digest", http::digest_field(output.sha256));
  if (name != request.path_parts.at("name")) {
    response.headers.add("Vary", "Accept");
    response.headers.add("Content-Location", output_path(job.id, name));
  }
  return response;
}

/// The answer once the mesh is made in this format.
Response when_made(const Request& request, const Job& job, const std::string& name, JobService& service,
                   const std::shared_ptr<http::Permits>& waits) {
  const auto permit = acquire_permit(request, waits);
  if (!permit) return problem_response(permit.error(), request);
  const auto ordered = service.order_output(job, name);
  if (!ordered) return problem_response(ordered.error(), request);
  const auto order = *ordered;
  Request asked = request;
  asked.body = nullptr;
  auto deferred = std::make_shared<http::DeferredResponse>();
  deferred->deadline = std::chrono::steady_clock::now() + kPatience;
  deferred->subscribe = [&service, order](std::function<void()> wake) {
    return service.watch(*order, std::move(wake));
  };
  deferred->poll = [&service, order, job, asked = std::move(asked),
                    permit = *permit](bool last) -> std::optional<Response> {
    const auto made = service.made(*order);
    if (made && *made) return output_response(asked, job, order->name, **made, service);
    if (made) return problem_response(made->error(), asked);
    if (!last) return std::nullopt;
    return problem_response({ErrorCode::not_ready, order->name + " of job " + job.id + " is still being made"}, asked);
  };
  Response response;
  response.deferred = std::move(deferred);
  return response;
}

Response get_output(const Request& request, JobService& service, const std::shared_ptr<http::Permits>& waits) {
  const auto job = service.find(request.path_parts.at("id"));
  if (!job) return problem_response(job.error(), request);
  const auto name = wanted_name(request, *job);
  if (!name) return problem_response(name.error(), request);
  const auto output = find_output(*job, *name);
  if (!output) return problem_response(output.error(), request);
  if (*output) return output_response(request, *job, *name, **output, service);
  return when_made(request, *job, *name, service, waits);
}

}  // namespace

void add_output_routes(http::Router& router, JobService& service, const RouteOptions& options) {
  router.add("GET", "/v1/jobs/{id}/outputs/{name}",
             [&service, waits = options.waits](Request& request) { return get_output(request, service, waits); });
}

}  // namespace surfaced::api
