// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "access/access_filter.hpp"
#include "api/job_service.hpp"
#include "api/routes.hpp"
#include "clouds/cloud_service.hpp"
#include "config/settings.hpp"
#include "execution/renditions.hpp"
#include "http/router.hpp"
#include "uploads/finishing.hpp"
#include "webhooks/sender.hpp"
#include "worker/side_task.hpp"

namespace surfaced {

/// What the components stand on.
struct Dependencies {
  JobStore& jobs;
  ArtifactStore& artifacts;
  JobEvents& events;
  Scheduler& scheduler;
  AttemptLimits limits;
};

/// Everything of the service between the router and the stores, put together for `surfaced serve`.
class ServiceComponents {
 public:
  /// invalid_usage for settings that cannot be met, and what the stores say.
  static Result<std::unique_ptr<ServiceComponents>> open(const Dependencies& dependencies, const Settings& settings);
  ServiceComponents(const ServiceComponents&) = delete;
  ServiceComponents& operator=(const ServiceComponents&) = delete;
  ~ServiceComponents() { stop(); }

  /// Adds the routes, with the access filter before them.
  void add_routes(http::Router& router, std::function<std::string()> metrics);

  api::JobService& service() { return service_; }

  void start();
  /// To be called now and then.
  void sweep();
  void stop();

 private:
  ServiceComponents(const Dependencies& dependencies, const Settings& settings, std::unique_ptr<CloudStore> clouds,
                    std::unique_ptr<UploadStore> uploads, std::unique_ptr<DeliveryStore> deliveries);

  const Settings settings_;
  std::unique_ptr<CloudStore> cloud_store_;
  std::unique_ptr<UploadStore> uploads_;
  std::unique_ptr<DeliveryStore> deliveries_;
  SideTask inspecting_;
  SideTask converting_;
  CloudInspector inspector_;
  CloudService clouds_;
  UploadFinishing finishing_;
  Renditions renditions_;
  api::JobService service_;
  AccessFilter access_;
  std::unique_ptr<WebhookSender> webhooks_;
};

/// A server that everybody can reach is to know who asks; invalid_usage.
Status check_exposure(const Settings& settings, std::string_view host);

}  // namespace surfaced
