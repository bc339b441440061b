// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace surfaced {

/// Every limit and choice of `surfaced serve`; units and bounds stand in setting_table.cpp, the only list.
struct Settings {
  std::string listen = "127.0.0.1:8080";
  std::filesystem::path data;
  std::string log_format = "text";
  std::string log_level = "info";

  /// 0: as many as cores.
  std::uint64_t workers = 0;
  /// 0: all cores.
  std::uint64_t threads_per_job = 0;
  std::uint64_t job_time_limit = 3600;
  /// 0: three quarters of the machine's, shared by the workers.
  std::uint64_t job_memory = 0;
  std::uint64_t job_output = std::uint64_t{16} << 30;
  std::uint64_t max_points = 500'000'000;

  std::uint64_t queue_limit = 1000;
  std::uint64_t ttl = std::uint64_t{24} * 3600;
  std::uint64_t gone_time = std::uint64_t{24} * 3600;
  std::uint64_t lease = 30;
  std::uint64_t minimum_free = std::uint64_t{256} << 20;

  std::uint64_t wait_limit = 30;
  std::uint64_t body_limit = std::uint64_t{4} << 30;
  std::uint64_t body_grace = 30;
  std::uint64_t body_rate = 4096;
  std::uint64_t header_limit = 32 << 10;
  std::uint64_t header_time = 10;
  std::uint64_t idle_time = 5;
  std::uint64_t connections = 2000;
  std::uint64_t requests_per_connection = 1000;
  std::uint64_t http_threads = 64;
  std::uint64_t bodies = 48;
  std::uint64_t bodies_per_client = 16;
  std::uint64_t streams = 1500;
  std::uint64_t streams_per_client = 100;
  std::uint64_t waits = 400;
  std::uint64_t waits_per_client = 100;

  std::uint64_t drain_time = 5;
  std::uint64_t drain_delay = 0;

  /// Both or none; none: plain HTTP.
  std::filesystem::path tls_certificate;
  std::filesystem::path tls_key;
  /// Empty: nobody needs a key.
  std::filesystem::path keys;
  std::string allow_anonymous = "no";
  std::uint64_t rate_limit = 600;
  std::uint64_t submission_rate_limit = 120;
  /// Separated by commas.
  std::string cors_origins;
  /// Separated by commas.
  std::string trusted_proxies;
  /// Separated by commas; * for all.
  std::string allowed_hosts;
  std::uint64_t upload_time = std::uint64_t{24} * 3600;
  std::uint64_t uploads = 1000;
  std::uint64_t uploads_per_client = 100;
  std::uint64_t cloud_time = std::uint64_t{30} * 24 * 3600;
  /// Empty: no webhooks.
  std::filesystem::path webhook_secret;
  std::string webhook_private = "no";
  /// Empty: those of the system.
  std::filesystem::path webhook_certificates;

  /// Puts numbers in the place of the zeros above.
  void resolve();
};

}  // namespace surfaced
