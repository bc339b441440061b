#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "api/job_service.hpp"
#include "http/router.hpp"

namespace surfaced::api {

struct RouteOptions {
  /// How long POST /v1/reconstruct waits for the mesh.
  std::chrono::milliseconds reconstruct_wait{30'000};
  /// Time to live of a job that asks for none.
  std::chrono::seconds ttl{};
  /// Text of /metrics.
  std::function<std::string()> metrics;
};

/// Every path of the service, as proto/openapi.yaml lists them.
void add_routes(http::Router& router, JobService& service, const RouteOptions& options);

void add_job_routes(http::Router& router, JobService& service, const RouteOptions& options);
void add_output_routes(http::Router& router, JobService& service);
void add_info_routes(http::Router& router, JobService& service, const RouteOptions& options);

}  // namespace surfaced::api
