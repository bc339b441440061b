#include <fcntl.h>
#include <sys/signal.h>
#include <unistd.h>

#include <csignal>
#include <ctime>
#include <iostream>
#include <memory>
#include <thread>

#include "api/job_service.hpp"
#include "api/routes.hpp"
#include "artifacts/file_artifact_store.hpp"
#include "command/command.hpp"
#include "command/problem.hpp"
#include "config/serve_options.hpp"
#include "http/router.hpp"
#include "http/server.hpp"
#include "jobs/scheduler.hpp"
#include "jobs/sqlite_job_store.hpp"
#include "reconstruction/reconstruction.hpp"
#include "worker/attempt_main.hpp"

namespace surfaced {
namespace {

constexpr std::time_t kSecondsBetweenSweeps = 30;
/// Name of the command that the server starts for every attempt.
constexpr const char* kAttemptCommand = "attempt";

/// The signals that stop the server. Blocked in every thread, they are taken by `wait` alone.
class StopSignals {
 public:
  StopSignals() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGTERM);
    sigaddset(&signals_, SIGINT);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
  }
  /// True if one has come, false if the time is over.
  bool wait(std::time_t seconds) const {
    const timespec time{seconds, 0};
    return ::sigtimedwait(&signals_, nullptr, &time) > 0;
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
  return {settings.job_memory, settings.max_points, std::uint64_t{1} << 40,
          std::chrono::seconds(settings.job_time_limit), settings.threads_per_job};
}

http::ServerLimits server_limits(const Settings& settings) {
  http::ServerLimits limits;
  limits.body_bytes = settings.body_limit;
  limits.connection.head_bytes = settings.header_limit;
  limits.connection.head_time = std::chrono::seconds(settings.header_time);
  limits.connections = settings.connections;
  return limits;
}

/// Brings back what the server before left behind: its running jobs go back to the queue, files that
/// no job refers to are removed. If the store cannot be read, nothing is removed.
Status recover(JobStore& jobs, ArtifactStore& artifacts) {
  const auto recovered = jobs.recover();
  if (!recovered) return recovered.error();
  const auto kept = jobs.kept();
  if (!kept) return kept.error();
  const auto swept = artifacts.sweep(*kept);
  if (!swept) return swept.error();
  if (*recovered + *swept > 0) {
    std::cerr << "recovered " << *recovered << " running jobs, removed " << *swept << " files that no job needs\n";
  }
  return Done{};
}

void remove_expired(JobStore& jobs, ArtifactStore& artifacts) {
  for (;;) {
    const auto garbage = jobs.expire();
    if (!garbage) std::cerr << "cannot remove expired jobs: " << garbage.error().detail << std::endl;
    if (!garbage || garbage->inputs.empty()) return;
    artifacts.remove(*garbage);
  }
}

Status serve(const Settings& settings) {
  const StopSignals signals;
  const auto address = http::parse_address(settings.listen);
  if (!address) return address.error();
  const auto lock = DataLock::acquire(settings.data);
  if (!lock) return lock.error();
  const auto jobs =
      open_sqlite_job_store(settings.data / "jobs.sqlite", {settings.queue_limit, std::chrono::hours(24)});
  if (!jobs) return jobs.error();
  const auto artifacts = open_file_artifact_store(settings.data, settings.minimum_free);
  if (!artifacts) return artifacts.error();

  JobEvents events;
  const AttemptRunner runner({"/proc/self/exe", kAttemptCommand});
  Scheduler scheduler(**jobs, **artifacts, events, runner, {settings.workers, attempt_limits(settings)});
  api::JobService service(**jobs, **artifacts, events, scheduler);
  http::Router router;
  api::add_routes(router, service, {std::chrono::seconds(settings.wait_limit), std::chrono::seconds(settings.ttl)});
  const auto server = http::Server::listen(*address, server_limits(settings), router);
  if (!server) return server.error();
  if (Status recovered = recover(**jobs, **artifacts); !recovered.ok()) return recovered;

  scheduler.start();
  (*server)->start();
  std::cout << "surfaced " << version() << " listening on " << (*server)->url() << std::endl;
  while (!signals.wait(kSecondsBetweenSweeps)) remove_expired(**jobs, **artifacts);

  const std::chrono::seconds grace(settings.drain_time);
  std::thread draining([&] { scheduler.drain(grace); });
  (*server)->stop(grace);
  draining.join();
  return Done{};
}

}  // namespace

void add_serve(CLI::App& app, Run& run) {
  auto settings = std::make_shared<Settings>();
  CLI::App* command = app.add_subcommand("serve", "Serve reconstruction over HTTP");
  add_serve_options(*command, *settings);
  command->callback([settings, &run] {
    run = [settings] {
      take_standard_descriptors();
      settings->resolve();
      const Status served = serve(*settings);
      return served ? 0 : report_problem(served.error());
    };
  });
}

void add_attempt(CLI::App& app, Run& run) {
  auto description = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(kAttemptCommand, "One attempt at a job; the server starts this itself");
  command->group("");
  command->add_option("DESCRIPTION", *description)->required();
  command->callback([description, &run] { run = [description] { return attempt_main(*description); }; });
}

}  // namespace surfaced
