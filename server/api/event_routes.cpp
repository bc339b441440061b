// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/event_stream.hpp"
#include "api/routes.hpp"
#include "api/waiting.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using http::problem_response;
using http::Request;
using http::Response;

/// The log grows without anybody saying so.
constexpr std::chrono::milliseconds kLookAtLog{2'000};

Response get_events(const Request& request, JobService& service, JobLooks& looks,
                    const std::shared_ptr<http::Permits>& permits) {
  const std::string& id = request.path_parts.at("id");
  const auto job = service.find(id);
  if (!job) return problem_response(job.error(), request);
  // What is not one of our ids begins anew, as a browser without one would.
  const auto position = read_event_id(request.headers.find("Last-Event-ID").value_or("")).value_or(EventPosition{});
  Response response;
  response.headers.add("Cache-Control", "no-store");
  if (position.state == "done" && ended(job->status) && position.attempt == job->attempt) {
    // Tells a browser not to connect again.
    response.status = 204;
    return response;
  }
  const auto permit = acquire_permit(request, permits);
  if (!permit) return problem_response(permit.error(), request);
  response.headers.add("X-Accel-Buffering", "no");
  response.content_type = "text/event-stream";
  const auto look = looks.at(id);
  auto stream = std::make_shared<EventStream>(look, id, position);
  auto streaming = std::make_shared<http::StreamingResponse>();
  streaming->interval = kLookAtLog;
  streaming->subscribe = [&service, id](std::function<void()> wake) { return service.watch(id, std::move(wake)); };
  streaming->next = [stream, permit = *permit](bool /*last*/) { return stream->next(); };
  response.streaming = std::move(streaming);
  return response;
}

}  // namespace

void add_event_routes(http::Router& router, JobService& service, const RouteOptions& options) {
  const auto looks = std::make_shared<JobLooks>(service);
  router.add("GET", "/v1/jobs/{id}/events", [&service, looks, streams = options.streams](Request& request) {
    return get_events(request, service, *looks, streams);
  });
}

}  // namespace surfaced::api
