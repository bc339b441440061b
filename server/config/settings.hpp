#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/base.hpp"

namespace surfaced {

/// Every limit and choice of `surfaced serve`. Each is a flag and an environment variable; the flag wins.
struct Settings {
  std::string listen = "127.0.0.1:8080";
  std::filesystem::path data;

  /// Jobs that run at once; 0 for the number of cores.
  unsigned workers = 0;
  /// Threads a job may use; 0 for all cores.
  unsigned threads_per_job = 0;

  /// Jobs that may wait.
  std::uint64_t queue_limit = 1000;
  /// Seconds that POST /v1/reconstruct waits for the mesh.
  std::uint64_t wait_limit = 30;
  /// Seconds that a job is kept after its end.
  std::uint64_t ttl = std::uint64_t{24} * 3600;

  /// Bytes of a request's body.
  std::uint64_t body_limit = std::uint64_t{4} << 30;
  /// Bytes of request line and header fields.
  std::uint64_t header_limit = 32 << 10;
  /// Seconds in which a whole head has to arrive.
  std::uint64_t header_time = 10;
  /// Connections at once.
  std::uint64_t connections = 2000;

  /// Seconds a job may run.
  std::uint64_t job_time_limit = 3600;
  /// Bytes of memory (data segment) a job may use; 0 for three quarters of the machine's, shared by the workers.
  std::uint64_t job_memory = 0;
  /// Points a cloud may have.
  std::uint64_t max_points = 500'000'000;

  /// Bytes under --data that are to stay free.
  std::uint64_t minimum_free = std::uint64_t{256} << 20;
  /// Seconds that running jobs get to end when the server is told to stop.
  std::uint64_t drain_time = 5;

  /// Puts numbers in the place of the zeros above.
  void resolve();
};

}  // namespace surfaced
