// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "api/job_service.hpp"
#include "api/submission.hpp"
#include "http/permits.hpp"
#include "http/router.hpp"
#include "uploads/finishing.hpp"
#include "webhooks/delivery_store.hpp"

namespace surfaced::api {

struct RouteOptions {
  /// How long POST /v1/reconstruct waits for the mesh.
  std::chrono::milliseconds reconstruct_wait{30'000};
  SubmissionRules rules;
  /// Bytes of a cloud.
  std::uint64_t body_bytes = 0;
  /// How long a stored cloud is kept that nobody uses; zero for ever.
  std::chrono::seconds cloud_time{};
  /// Event streams at once; those of all jobs share them.
  std::shared_ptr<http::Permits> streams;
  /// Requests at once that wait for a job or a mesh.
  std::shared_ptr<http::Permits> waits;
  /// Text of /metrics.
  std::function<std::string()> metrics;
};

/// Every path of the service, as proto/openapi.yaml lists them.
void add_routes(http::Router& router, JobService& service, CloudService& clouds, UploadFinishing& uploads,
                const RouteOptions& options);

void add_submit_routes(http::Router& router, JobService& service, const RouteOptions& options);
void add_ogc_routes(http::Router& router, JobService& service, const RouteOptions& options);
void add_delivery_routes(http::Router& router, JobService& service, DeliveryStore& deliveries);
void add_event_routes(http::Router& router, JobService& service, const RouteOptions& options);
void add_job_routes(http::Router& router, JobService& service, const RouteOptions& options);
void add_upload_routes(http::Router& router, JobService& service, UploadFinishing& finishing, std::uint64_t most_bytes);
/// @param kept  how long a cloud is kept that nobody uses; zero for ever
void add_cloud_routes(http::Router& router, JobService& service, CloudService& clouds, std::chrono::seconds kept);
void add_output_routes(http::Router& router, JobService& service, const RouteOptions& options);
/// The viewer and the files it needs; `index` answers at the root whoever does not ask for HTML.
void add_viewer_routes(http::Router& router, http::Handler index);
void add_info_routes(http::Router& router, JobService& service, const RouteOptions& options);

}  // namespace surfaced::api
