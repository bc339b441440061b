#include "config/serve_options.hpp"

#include <limits>
#include <string>

namespace surfaced {
namespace {

constexpr std::uint64_t kDay = std::uint64_t{24} * 3600;
constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 60;

/// --job-memory becomes SURFACED_JOB_MEMORY.
std::string environment_name(std::string_view flag) {
  std::string name = "SURFACED_";
  for (const char c : flag.substr(2))
    name += c == '-' ? '_' : static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  return name;
}

template <class Value>
CLI::Option* add(CLI::App& command, const char* flag, Value& value, const char* text) {
  return command.add_option(flag, value, text)->capture_default_str()->envname(environment_name(flag));
}

void add_number(CLI::App& command, const char* flag, std::uint64_t& value, const char* text, std::uint64_t least,
                std::uint64_t most) {
  add(command, flag, value, text)->check(CLI::Range(least, most));
}

/// Takes 4096, 64KiB, 4GiB. CLI11 runs transformations before checks.
void add_bytes(CLI::App& command, const char* flag, std::uint64_t& value, const char* text, std::uint64_t least) {
  add(command, flag, value, text)
      ->transform(CLI::AsSizeValue(false))
      ->check(CLI::Range(least, kMaxBytes))
      ->type_name("BYTES");
}

}  // namespace

void add_serve_options(CLI::App& command, Settings& settings) {
  add(command, "--listen", settings.listen, "Address to listen on; port 0 takes a free one")->type_name("HOST:PORT");
  command.add_option("--data", settings.data, "Folder of the job store and all files; one server at a time")
      ->required()
      ->type_name("DIR")
      ->envname("SURFACED_DATA");
  add(command, "--workers", settings.workers, "Jobs that run at once; 0: as many as cores")
      ->check(CLI::Range(0U, 1024U));
  add(command, "--threads-per-job", settings.threads_per_job, "Threads a job may use; 0: all cores")
      ->check(CLI::Range(0U, 1024U));
  add_number(command, "--queue-limit", settings.queue_limit, "Jobs that may wait", 1, 1'000'000);
  add_number(command, "--wait-limit", settings.wait_limit, "Seconds that /v1/reconstruct waits for the mesh", 0, 600);
  add_number(command, "--ttl", settings.ttl, "Seconds that a job is kept after its end", 1, 365 * kDay);
  add_bytes(command, "--body-limit", settings.body_limit, "Bytes of a request's body", 1);
  add_bytes(command, "--header-limit", settings.header_limit, "Bytes of a request's line and headers", 1024);
  add_number(command, "--header-time", settings.header_time, "Seconds in which a request's headers have to arrive", 1,
             600);
  add_number(command, "--connections", settings.connections, "Connections at once", 2, 100000);
  add_number(command, "--job-time-limit", settings.job_time_limit, "Seconds a job may run", 1, 30 * kDay);
  add_bytes(command, "--job-memory", settings.job_memory,
            "Bytes of memory a job may use; 0: 3/4 of the machine's over the workers", 0);
  add_number(command, "--max-points", settings.max_points, "Points a cloud may have", 1, 4'000'000'000);
  add_bytes(command, "--minimum-free", settings.minimum_free, "Bytes under --data that are to stay free", 0);
  add_number(command, "--drain-time", settings.drain_time, "Seconds that running jobs get when the server stops", 0,
             3600);
}

}  // namespace surfaced
