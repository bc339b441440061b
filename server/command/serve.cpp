// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <ctime>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "artifacts/file_artifact_store.hpp"
#include "artifacts/orphans.hpp"
#include "backup/backup.hpp"
#include "command/command.hpp"
#include "command/problem.hpp"
#include "command/serve_options.hpp"
#include "command/service_components.hpp"
#include "execution/scheduler.hpp"
#include "http/router.hpp"
#include "http/server.hpp"
#include "http/tls.hpp"
#include "jobs/sqlite_job_store.hpp"
#include "observability/log.hpp"
#include "observability/metrics.hpp"
#include "observability/survives.hpp"
#include "platform/machine.hpp"
#include "platform/service_manager.hpp"
#include "reconstruction/reconstruction.hpp"
#include "worker/attempt_main.hpp"

namespace surfaced {
namespace {

constexpr std::time_t kSecondsBetweenSweeps = 30;
constexpr unsigned kSweepsBetweenOrphans = 20;
/// What clients get to take their last answers once the server has stopped listening.
constexpr std::chrono::milliseconds kGraceOfAnswers{5000};
constexpr auto kLogLevels = std::to_array<std::string_view>({"debug", "info", "warning", "error"});
/// Name of the command that the server starts for every attempt.
constexpr const char* kAttemptCommand = "attempt";

/// The signals that stop the server or have it read its certificate again. Blocked in every thread, they are taken by
/// `wait` alone.
class Signals {
 public:
  Signals() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGTERM);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
  }
  /// The one that has come, or none if the time is over.
  std::optional<int> wait(std::time_t seconds) const {
    const timespec time{seconds, 0};
    const int signal = ::sigtimedwait(&signals_, nullptr, &time);
    return signal > 0 ? std::optional(signal) : std::nullopt;
  }

 private:
  sigset_t signals_{};
};

/// Descriptors 0 to 2 must be taken, or files of the server would get their numbers.
void take_standard_descriptors() {
  int fd = 0;
  do {
    fd = ::open("/dev/null", O_RDWR);
  } while (fd >= 0 && fd <= STDERR_FILENO);
  if (fd > STDERR_FILENO) ::close(fd);
}

AttemptLimits attempt_limits(const Settings& settings) {
  return {settings.job_memory,
          settings.max_points,
          settings.job_output,
          std::chrono::seconds(settings.job_time_limit),
          static_cast<unsigned>(settings.threads_per_job),
          settings.minimum_free};
}

http::ServerLimits server_limits(const Settings& settings) {
  using std::chrono::seconds;
  http::ServerLimits limits;
  limits.connection.head_bytes = settings.header_limit;
  limits.connection.head_time = seconds(settings.header_time);
  limits.connection.idle_time = seconds(settings.idle_time);
  limits.connection.body_grace = seconds(settings.body_grace);
  limits.connection.body_rate = settings.body_rate;
  limits.body_bytes = settings.body_limit;
  limits.connections = settings.connections;
  limits.threads = settings.http_threads;
  limits.bodies = settings.bodies;
  limits.bodies_per_address = settings.bodies_per_client;
  limits.requests = settings.requests_per_connection;
  return limits;
}

JobStoreLimits store_limits(const Settings& settings) {
  JobStoreLimits limits;
  limits.queue = settings.queue_limit;
  limits.tombstone = std::chrono::seconds(settings.gone_time);
  limits.lease = std::chrono::seconds(settings.lease);
  return limits;
}

/// Brings back what the server before left behind: its running jobs go back to the queue, files that
/// no job refers to are removed. If the store cannot be read, or is not the one that the files belong to, nothing is
/// removed.
Status recover(JobStore& jobs, ArtifactStore& artifacts) {
  const auto identity = jobs.identity();
  if (!identity) return identity.error();
  if (Status ours = artifacts.belong_to(*identity); !ours.ok()) return ours;
  const auto recovered = jobs.recover();
  if (!recovered) return recovered.error();
  const auto wrong = jobs.recount_holdings();
  if (!wrong) return wrong.error();
  if (*wrong > 0) log(LogLevel::error, "what keys hold was counted wrong, and is put right", {{"keys", *wrong}});
  const auto kept = jobs.kept();
  if (!kept) return kept.error();
  const auto swept = artifacts.sweep(*kept);
  if (!swept) return swept.error();
  if (*recovered + *swept > 0) {
    log(LogLevel::info, "recovered what the server before left",
        {{"running_jobs", *recovered}, {"files_without_a_job", *swept}});
  }
  return Done{};
}

void remove_expired(JobStore& jobs, ArtifactStore& artifacts) {
  for (;;) {
    const auto garbage = jobs.expire();
    if (!garbage) log(LogLevel::error, "cannot remove expired jobs", {{"detail", garbage.error().detail}});
    if (!garbage || (garbage->inputs.empty() && garbage->outputs.empty())) return;
    artifacts.remove(*garbage);
    log(LogLevel::info, "removed expired jobs", {{"jobs", garbage->inputs.size()}});
  }
}

void remove_orphans(OrphanSweep& orphans) {
  const auto removed = orphans.look();
  if (!removed) log(LogLevel::error, "cannot look for files without a job", {{"detail", removed.error().detail}});
  if (removed && *removed > 0) log(LogLevel::warning, "removed files without a job", {{"files", *removed}});
}

void tell_of_attempt(Metrics& metrics, const Scheduler::Ended& ended) {
  const Job& job = ended.job.job;
  const AttemptResult& result = ended.result;
  metrics.attempt(job.method, name_of(result.outcome), result.usage.seconds, result.usage.peak_memory_bytes);
  for (const auto& [stage, seconds] : ended.stages) metrics.stage(job.method, stage, seconds);
  const bool ours = result.outcome == Outcome::lost;
  log(ours ? LogLevel::warning : LogLevel::info, "attempt ended",
      {{"job", job.id},
       {"attempt", job.attempt},
       {"request_id", job.request_id},
       {"trace_id", trace_id_of(job.traceparent)},
       {"method", job.method},
       {"outcome", name_of(result.outcome)},
       {"seconds", result.usage.seconds},
       {"peak_memory_bytes", result.usage.peak_memory_bytes},
       {"detail", result.error ? result.error->detail : ""}});
}

void tell_of_request(Metrics& metrics, const http::Exchange& answered) {
  const auto& request = answered.request;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - answered.began).count();
  metrics.request(request.method, request.route, answered.status, seconds);
  const bool probe = request.route == "/healthz" || request.route == "/readyz" || request.route == "/metrics";
  log(probe ? LogLevel::debug : LogLevel::info, "request",
      {{"request_id", request.request_id},
       {"trace_id", trace_id_of(request.headers.find("traceparent").value_or(""))},
       {"method", request.method},
       {"path", request.path},
       {"status", answered.status},
       {"seconds", seconds},
       {"client", request.remote_address}});
}

/// Everything that serves, in the order in which it is made.
class Service {
 public:
  Service(const Settings& settings, std::unique_ptr<JobStore> jobs, std::unique_ptr<ArtifactStore> artifacts)
      : settings_(settings),
        jobs_(std::move(jobs)),
        artifacts_(std::move(artifacts)),
        scheduler_(*jobs_, *artifacts_, events_, runner_, scheduler_options()),
        orphans_(*jobs_, *artifacts_) {}

  Status start() {
    const auto address = http::parse_address(settings_.listen);
    if (!address) return address.error();
    if (Status known = check_exposure(settings_, address->host); !known.ok()) return known;
    auto components =
        ServiceComponents::open({*jobs_, *artifacts_, events_, scheduler_, attempt_limits(settings_)}, settings_);
    if (!components) return std::move(components).error();
    components_ = std::move(*components);
    components_->add_routes(router_, [this] { return metrics_.text(gauges()); });
    if (!settings_.tls_certificate.empty()) {
      auto tls = http::Tls::load({settings_.tls_certificate, settings_.tls_key});
      if (!tls) return tls.error();
      tls_ = std::move(*tls);
    }
    auto server = http::Server::listen(
        *address, server_limits(settings_), router_,
        [this](const http::Exchange& answered) { tell_of_request(metrics_, answered); }, tls_.get());
    if (!server) {
      return with_fault(server.error(), {"listen", settings_.listen,
                                         "HOST:PORT of this machine that no other program has; ss -ltnp shows who has "
                                         "which, port 0 takes a free one"});
    }
    server_ = std::move(*server);
    if (Status recovered = recover(*jobs_, *artifacts_); !recovered.ok()) return recovered;
    scheduler_.start();
    components_->start();
    server_->start();
    std::cout << "surfaced " << version() << " listening on " << server_->url() << std::endl;
    log(LogLevel::info, "listening", {{"url", server_->url()}, {"version", version()}});
    tell_service_manager("READY=1");
    return Done{};
  }

  /// Returns when the server is told to stop.
  void run(const Signals& signals) {
    unsigned sweeps = 0;
    for (;;) {
      const auto signal = signals.wait(kSecondsBetweenSweeps);
      // Without a certificate it means what it always does: that the terminal is gone.
      if (signal == SIGHUP && tls_) {
        reload();
        continue;
      }
      if (signal) return;
      survives("remove what has expired", [this] { remove_expired(*jobs_, *artifacts_); });
      survives("sweep uploads and clouds", [this] { components_->sweep(); });
      if (++sweeps % kSweepsBetweenOrphans == 0) survives("sweep", [this] { remove_orphans(orphans_); });
    }
  }

  /// Unready, no new jobs, no new claims; running jobs get their time while their clients are still answered; then
  /// HTTP ends, and what still runs is stopped and given back.
  void stop() {
    log(LogLevel::info, "stopping");
    tell_service_manager("STOPPING=1");
    components_->service().drain();
    const auto listen_until = std::chrono::steady_clock::now() + std::chrono::seconds(settings_.drain_delay);
    scheduler_.drain(std::chrono::seconds(settings_.drain_time));
    std::this_thread::sleep_until(listen_until);
    components_->stop();
    server_->stop(kGraceOfAnswers);
    log(LogLevel::info, "stopped");
  }

 private:
  void reload() {
    if (const Status read = tls_->reload(); !read) {
      log(LogLevel::error, "the certificate stays as it was", {{"detail", read.error().detail}});
    } else {
      log(LogLevel::info, "the certificate was read again", {{"ends", tls_->not_after()}});
    }
  }

  Scheduler::Options scheduler_options() {
    const std::chrono::milliseconds lease = std::chrono::seconds(settings_.lease);
    return {static_cast<unsigned>(settings_.workers), attempt_limits(settings_), lease / 3,
            [this](const Scheduler::Ended& ended) { tell_of_attempt(metrics_, ended); }};
  }

  Gauges gauges() {
    Gauges gauges;
    if (const auto census = jobs_->census()) {
      gauges.jobs_accepted = census->accepted;
      gauges.jobs_running = census->running;
      // A clock that was set back must not give a negative age.
      const auto age = now() - census->oldest_accepted.value_or(now());
      gauges.oldest_accepted_seconds = std::max(0.0, std::chrono::duration<double>(age).count());
    }
    const http::ServerState state = server_->state();
    gauges.connections = state.connections;
    gauges.connections_turned_away = state.turned_away;
    gauges.unsent_bytes = state.unsent_bytes;
    gauges.connections_cut_off = state.cut_off;
    gauges.free_bytes = artifacts_->free_bytes();
    gauges.resident_bytes = resident_memory();
    gauges.ready = components_->service().ready().ok();
    return gauges;
  }

  const Settings settings_;
  Metrics metrics_{version()};
  JobEvents events_;
  const AttemptRunner runner_{{"/proc/self/exe", kAttemptCommand}};
  const std::unique_ptr<JobStore> jobs_;
  const std::unique_ptr<ArtifactStore> artifacts_;
  Scheduler scheduler_;
  OrphanSweep orphans_;
  std::unique_ptr<ServiceComponents> components_;
  http::Router router_;
  std::unique_ptr<http::Tls> tls_;
  std::unique_ptr<http::Server> server_;
};

Status serve(const Settings& settings) {
  // Children run as the same user: they shall not read the memory or the environment of the server.
  ::prctl(PR_SET_DUMPABLE, 0);
  const Signals signals;
  raise_file_limit();
  const auto lock = DataLock::acquire(settings.data);
  if (!lock) return lock.error();
  if (Status ended = end_backup(settings.data); !ended.ok()) return ended;
  auto jobs = open_sqlite_job_store(settings.data / "jobs.sqlite", store_limits(settings));
  if (!jobs) return jobs.error();
  auto artifacts = open_file_artifact_store(settings.data, settings.minimum_free);
  if (!artifacts) return artifacts.error();
  Service service(settings, std::move(*jobs), std::move(*artifacts));
  if (Status started = service.start(); !started.ok()) return started;
  service.run(signals);
  service.stop();
  return Done{};
}

int serve_as_configured(Sources& sources) {
  use_environment(sources);
  Configuration configuration = read_configuration(sources);
  if (configuration.problems.empty()) check_machine(configuration);
  if (!configuration.problems.empty()) return report_problems(configuration.problems);
  Settings& settings = configuration.settings;
  const auto level = static_cast<LogLevel>(std::ranges::find(kLogLevels, settings.log_level) - kLogLevels.begin());
  set_up_log(settings.log_format == "json" ? LogFormat::json : LogFormat::text, level);
  for (const std::string& warning : configuration.warnings) log(LogLevel::warning, warning);
  take_standard_descriptors();
  settings.resolve();
  const Status served = serve(settings);
  return served ? 0 : report_problem(served.error());
}

}  // namespace

void add_serve(CLI::App& app, Run& run) {
  auto sources = std::make_shared<Sources>();
  CLI::App* command = app.add_subcommand("serve", "Serve reconstruction over HTTP");
  add_setting_flags(*command, *sources);
  command->callback([sources, &run] { run = [sources] { return serve_as_configured(*sources); }; });
}

void add_attempt(CLI::App& app, Run& run) {
  auto description = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(kAttemptCommand, "One attempt at a job; the server starts this itself");
  command->group("");
  command->add_option("DESCRIPTION", *description)->required();
  command->callback([description, &run] { run = [description] { return attempt_main(*description); }; });
}

}  // namespace surfaced
