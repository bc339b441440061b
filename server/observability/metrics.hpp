// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace surfaced {

/// What is counted at the moment of a scrape.
struct Gauges {
  std::uint64_t jobs_accepted = 0;
  std::uint64_t jobs_running = 0;
  double oldest_accepted_seconds = 0;
  std::uint64_t connections = 0;
  std::uint64_t connections_turned_away = 0;
  std::uint64_t unsent_bytes = 0;
  std::uint64_t connections_cut_off = 0;
  std::uint64_t free_bytes = 0;
  std::uint64_t resident_bytes = 0;
  bool ready = false;
};

/// The numbers of the service, for Prometheus. Safe in threads. Labels have few values: a child's names of stages
/// are untrusted, so only the first 64 are taken, and those after it counted as "other".
class Metrics {
 public:
  explicit Metrics(std::string_view version);
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  /// @param route  its pattern; empty if no route was found
  void request(std::string_view method, std::string_view route, int status, double seconds);
  void attempt(std::string_view method, std::string_view outcome, double seconds, std::uint64_t peak_memory_bytes);
  void stage(std::string_view method, std::string_view name, double seconds);

  /// All of it in the text format of Prometheus.
  std::string text(const Gauges& gauges);

 private:
  struct Families;
  std::unique_ptr<Families> families_;
};

}  // namespace surfaced
