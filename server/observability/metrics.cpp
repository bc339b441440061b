// SPDX-License-Identifier: GPL-3.0-or-later
#include "observability/metrics.hpp"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <set>

namespace surfaced {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;
using prometheus::Histogram;
using prometheus::Registry;

constexpr std::size_t kStages = 64;
constexpr std::size_t kStageBytes = 40;

const Histogram::BucketBoundaries kRequestSeconds{0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60};
const Histogram::BucketBoundaries kWorkSeconds{0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100, 300, 1000, 3000};
const Histogram::BucketBoundaries kMemoryBytes{16777216.,   67108864.,   268435456.,
                                               1073741824., 4294967296., 17179869184.};

std::string known_method(std::string_view method) {
  constexpr auto kMethods =
      std::to_array<std::string_view>({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"});
  return std::ranges::find(kMethods, method) == kMethods.end() ? "other" : std::string(method);
}

}  // namespace

struct Metrics::Families {
  Registry registry;
  prometheus::Family<prometheus::Counter>& requests =
      BuildCounter().Name("surfaced_http_requests_total").Help("Requests answered").Register(registry);
  prometheus::Family<Histogram>& request_seconds = BuildHistogram()
                                                       .Name("surfaced_http_request_seconds")
                                                       .Help("From the end of the head to the answer")
                                                       .Register(registry);
  prometheus::Family<prometheus::Counter>& attempts =
      BuildCounter().Name("surfaced_attempts_total").Help("Attempts by their outcome").Register(registry);
  prometheus::Family<Histogram>& attempt_seconds =
      BuildHistogram().Name("surfaced_attempt_seconds").Help("Duration of attempts").Register(registry);
  prometheus::Family<Histogram>& attempt_memory = BuildHistogram()
                                                      .Name("surfaced_attempt_peak_memory_bytes")
                                                      .Help("Peak memory of the processes of attempts")
                                                      .Register(registry);
  prometheus::Family<Histogram>& stage_seconds =
      BuildHistogram().Name("surfaced_stage_seconds").Help("Duration of the stages of attempts").Register(registry);
  prometheus::Family<prometheus::Gauge>& jobs =
      BuildGauge().Name("surfaced_jobs").Help("Jobs that have not ended").Register(registry);
  prometheus::Gauge& oldest = one("surfaced_oldest_accepted_seconds", "Age of the job that waits longest");
  prometheus::Gauge& connections = one("surfaced_connections", "Open connections");
  prometheus::Gauge& turned_away =
      one("surfaced_connections_turned_away", "Connections that found no place since the start");
  prometheus::Gauge& unsent = one("surfaced_unsent_bytes", "Bytes of answers that clients have not taken yet");
  prometheus::Gauge& cut_off =
      one("surfaced_connections_cut_off", "Connections that were ended since the start because they took nothing");
  prometheus::Gauge& free_bytes = one("surfaced_free_bytes", "Free space under the data folder");
  prometheus::Gauge& resident = one("surfaced_resident_bytes", "Memory of the server process");
  prometheus::Gauge& ready = one("surfaced_ready", "1 if /readyz says so");
  std::mutex mutex;
  std::set<std::string, std::less<>> stages;

  prometheus::Gauge& one(const char* name, const char* help) {
    return BuildGauge().Name(name).Help(help).Register(registry).Add({});
  }

  /// The name as a label, as long as there are not too many.
  std::string stage_label(std::string_view name) {
    const bool plain = !name.empty() && name.size() <= kStageBytes && std::ranges::all_of(name, [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == ' ';
    });
    if (!plain) return "other";
    const std::scoped_lock lock(mutex);
    if (stages.contains(name)) return std::string(name);
    if (stages.size() >= kStages) return "other";
    return *stages.emplace(name).first;
  }
};

Metrics::Metrics(std::string_view version) : families_(std::make_unique<Families>()) {
  BuildGauge()
      .Name("surfaced_build_info")
      .Help("Version of the server")
      .Register(families_->registry)
      .Add({{"version", std::string(version)}})
      .Set(1);
}

Metrics::~Metrics() = default;

void Metrics::request(std::string_view method, std::string_view route, int status, double seconds) {
  const std::string where(route.empty() ? "none" : route);
  families_->requests.Add({{"method", known_method(method)}, {"route", where}, {"status", std::to_string(status)}})
      .Increment();
  families_->request_seconds.Add({{"route", where}}, kRequestSeconds).Observe(seconds);
}

void Metrics::attempt(std::string_view method, std::string_view outcome, double seconds,
                      std::uint64_t peak_memory_bytes) {
  const std::string name(method);
  families_->attempts.Add({{"method", name}, {"outcome", std::string(outcome)}}).Increment();
  families_->attempt_seconds.Add({{"method", name}}, kWorkSeconds).Observe(seconds);
  families_->attempt_memory.Add({{"method", name}}, kMemoryBytes).Observe(static_cast<double>(peak_memory_bytes));
}

void Metrics::stage(std::string_view method, std::string_view name, double seconds) {
  families_->stage_seconds.Add({{"method", std::string(method)}, {"stage", families_->stage_label(name)}}, kWorkSeconds)
      .Observe(seconds);
}

std::string Metrics::text(const Gauges& gauges) {
  const std::scoped_lock lock(families_->mutex);
  families_->jobs.Add({{"status", "accepted"}}).Set(static_cast<double>(gauges.jobs_accepted));
  families_->jobs.Add({{"status", "running"}}).Set(static_cast<double>(gauges.jobs_running));
  families_->oldest.Set(gauges.oldest_accepted_seconds);
  families_->connections.Set(static_cast<double>(gauges.connections));
  families_->turned_away.Set(static_cast<double>(gauges.connections_turned_away));
  families_->unsent.Set(static_cast<double>(gauges.unsent_bytes));
  families_->cut_off.Set(static_cast<double>(gauges.connections_cut_off));
  families_->free_bytes.Set(static_cast<double>(gauges.free_bytes));
  families_->resident.Set(static_cast<double>(gauges.resident_bytes));
  families_->ready.Set(gauges.ready ? 1 : 0);
  return prometheus::TextSerializer().Serialize(families_->registry.Collect());
}

}  // namespace surfaced
