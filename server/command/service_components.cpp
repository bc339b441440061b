// SPDX-License-Identifier: GPL-3.0-or-later
#include "command/service_components.hpp"

#include <fstream>

#include "api/job_json.hpp"
#include "http/problem.hpp"
#include "http/server.hpp"
#include "observability/log.hpp"
#include "worker/side_main.hpp"

namespace surfaced {
namespace {

constexpr const char* kThisProgram = "/proc/self/exe";
constexpr std::size_t kShortestSecret = 16;

std::string webhook_body(const Job& job) {
  return http::text_of({{"type", "job." + std::string(name_of(job.status))},
                        {"timestamp", to_rfc3339(job.finished_at.value_or(now()))},
                        {"data", api::job_json(job)}});
}

Result<std::string> read_secret(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string secret;
  if (std::getline(stream, secret) && secret.size() >= kShortestSecret) return secret;
  return Error{ErrorCode::invalid_usage, "--webhook-secret " + file.string() +
                                             " is no file whose first line has at least " +
                                             std::to_string(kShortestSecret) + " characters"};
}

/// Checked with the configuration.
std::vector<Network> proxies_in(const Settings& settings) {
  auto networks = networks_in(settings.trusted_proxies);
  return networks ? std::move(*networks) : std::vector<Network>();
}

/// For a server that asks nobody for a key.
std::optional<BrowserGuard> browser_guard(const Settings& settings) {
  if (!settings.keys.empty()) return std::nullopt;
  return BrowserGuard(api::split_list(settings.allowed_hosts), api::split_list(settings.cors_origins));
}

}  // namespace

Status check_exposure(const Settings& settings, std::string_view host) {
  if (!settings.keys.empty() || is_loopback(host)) return Done{};
  if (settings.allow_anonymous == "yes") {
    log(LogLevel::warning,
        "whoever reaches this address may use the server; to admit only those with a key: surfaced keys add FILE "
        "--name NAME, then start with --keys FILE (SURFACED_KEYS)",
        {{"listen", settings.listen}});
    return Done{};
  }
  return Error{ErrorCode::invalid_usage,
               "--listen " + settings.listen +
                   " is no loopback address and there are no keys; give --keys FILE "
                   "(surfaced keys add FILE), or --allow-anonymous yes if everybody may come in"};
}

Result<std::unique_ptr<ServiceComponents>> ServiceComponents::open(const Dependencies& dependencies,
                                                                   const Settings& settings) {
  const auto database = settings.data / "jobs.sqlite";
  auto clouds = open_sqlite_cloud_store(database);
  if (!clouds) return std::move(clouds).error();
  auto uploads = UploadStore::open(
      settings.data, {std::chrono::seconds(settings.upload_time), settings.uploads, settings.uploads_per_client});
  if (!uploads) return std::move(uploads).error();
  auto deliveries = open_sqlite_delivery_store(database);
  if (!deliveries) return std::move(deliveries).error();
  std::unique_ptr<ServiceComponents> components(
      new ServiceComponents(dependencies, settings, std::move(*clouds), std::move(*uploads), std::move(*deliveries)));
  if (Status opened = components->access_.open(); !opened.ok()) return opened.error();
  if (settings.webhook_secret.empty()) return components;
  const auto secret = read_secret(settings.webhook_secret);
  if (!secret) return secret.error();
  components->webhooks_ = std::make_unique<WebhookSender>(
      *components->deliveries_, dependencies.jobs,
      WebhookOptions{*secret, settings.webhook_private == "yes", settings.webhook_certificates.string()}, webhook_body);
  return components;
}

ServiceComponents::ServiceComponents(const Dependencies& dependencies, const Settings& settings,
                                     std::unique_ptr<CloudStore> clouds, std::unique_ptr<UploadStore> uploads,
                                     std::unique_ptr<DeliveryStore> deliveries)
    : settings_(settings),
      cloud_store_(std::move(clouds)),
      uploads_(std::move(uploads)),
      deliveries_(std::move(deliveries)),
      inspecting_(dependencies.artifacts, {kThisProgram, kInspectCommand}, dependencies.limits),
      converting_(dependencies.artifacts, {kThisProgram, kConvertCommand}, dependencies.limits),
      inspector_(*cloud_store_, dependencies.artifacts, inspecting_),
      clouds_(*cloud_store_, dependencies.artifacts, inspector_),
      finishing_(*uploads_, dependencies.artifacts, clouds_),
      renditions_(dependencies.jobs, dependencies.artifacts, converting_),
      service_(dependencies.jobs, dependencies.artifacts, clouds_, renditions_, dependencies.events,
               dependencies.scheduler),
      access_({settings.keys, settings.rate_limit, settings.submission_rate_limit, proxies_in(settings),
               api::split_list(settings.cors_origins), browser_guard(settings)},
              dependencies.jobs) {}

void ServiceComponents::add_routes(http::Router& router, std::function<std::string()> metrics) {
  const api::SubmissionRules rules{std::chrono::seconds(settings_.ttl), webhooks_ != nullptr};
  const auto streams =
      std::make_shared<http::Permits>("event streams are open", settings_.streams, settings_.streams_per_client);
  const auto waits =
      std::make_shared<http::Permits>("requests wait for an answer", settings_.waits, settings_.waits_per_client);
  const api::RouteOptions options{std::chrono::seconds(settings_.wait_limit),
                                  rules,
                                  settings_.body_limit,
                                  std::chrono::seconds(settings_.cloud_time),
                                  streams,
                                  waits,
                                  std::move(metrics)};
  router.set_filter(access_);
  api::add_routes(router, service_, clouds_, finishing_, options);
  api::add_delivery_routes(router, service_, *deliveries_);
}

void ServiceComponents::start() {
  inspector_.start();
  uploads_->sweep();
  finishing_.start();
  renditions_.start();
  if (webhooks_) webhooks_->start();
}

void ServiceComponents::sweep() {
  uploads_->sweep();
  finishing_.wake();
  if (settings_.cloud_time == 0) return;
  const auto removed = clouds_.expire(std::chrono::seconds(settings_.cloud_time));
  if (!removed) log(LogLevel::error, "cannot remove clouds that nobody uses", {{"detail", removed.error().detail}});
  if (removed && *removed > 0) log(LogLevel::info, "removed clouds that nobody uses", {{"clouds", *removed}});
}

void ServiceComponents::stop() {
  renditions_.stop();
  finishing_.stop();
  inspector_.stop();
  if (webhooks_) webhooks_->stop();
}

}  // namespace surfaced
