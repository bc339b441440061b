// SPDX-License-Identifier: GPL-3.0-or-later
// What tests of the running service do again and again.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/base.hpp"
#include "support/http_client.hpp"
#include "support/patience.hpp"
#include "support/server_process.hpp"

namespace surfaced::testing {

/// Binary little-endian PLY of these points.
inline std::string binary_ply(const std::vector<Point3>& points) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(points.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  bytes.reserve(bytes.size() + points.size() * 12);
  for (const Point3& point : points) {
    for (const double coordinate : point) {
      const auto value = static_cast<float>(coordinate);
      char raw[sizeof value];
      std::memcpy(raw, &value, sizeof value);
      bytes.append(raw, sizeof raw);
    }
  }
  return bytes;
}

inline nlohmann::json job_of(std::uint16_t port, const std::string& id, const std::string& query = "",
                             const Fields& fields = {}) {
  return nlohmann::json::parse(call(port, "GET", "/v1/jobs/" + id + query, "", fields).body);
}

inline bool is_active(const nlohmann::json& job) {
  return job.at("status") == "accepted" || job.at("status") == "running";
}

/// The job when it has ended, or as it is after three minutes.
inline nlohmann::json wait_for_end(std::uint16_t port, const std::string& id) {
  nlohmann::json now;
  for (int i = 0; i < 9; ++i) {
    now = job_of(port, id, "?wait=20");
    if (!is_active(now)) break;
  }
  return now;
}

/// The job once it runs (or has ended), or as it is after two minutes.
inline nlohmann::json wait_for_start(std::uint16_t port, const std::string& id, const Fields& fields = {}) {
  nlohmann::json now;
  eventually(
      [&] {
        now = job_of(port, id, "", fields);
        return now.at("status") != "accepted";
      },
      std::chrono::seconds(120));
  return now;
}

/// The job once it is past reading, in the middle of its method (or has ended).
inline nlohmann::json wait_for_method(std::uint16_t port, const std::string& id, const Fields& fields = {}) {
  nlohmann::json now = wait_for_start(port, id, fields);
  eventually(
      [&] {
        now = job_of(port, id, "", fields);
        return !is_active(now) || !(now.at("phase").is_null() || now.at("phase") == "read");
      },
      std::chrono::seconds(120));
  return now;
}

/// Submits a job that goes on for as long as a test needs it: its processes are stopped in the middle of the method,
/// where it takes no time from others. Lives until the job is dismissed, the server ends, or SIGCONT.
inline std::string start_endless_job(const ServerProcess& server, const std::vector<Point3>& points,
                                     const Fields& fields = {}) {
  for (int i = 0; i < 10; ++i) {
    const Answer made = call(server.port(), "POST", "/v1/jobs?method=advancing-front", binary_ply(points), fields);
    if (made.status != 201) throw std::runtime_error(made.body);
    const std::string id = nlohmann::json::parse(made.body).at("id");
    wait_for_method(server.port(), id, fields);
    for (const pid_t child : server.children()) ::kill(-child, SIGSTOP);
    if (is_active(job_of(server.port(), id, "", fields)) && !server.children().empty()) return id;
    // It was faster than this process, which had to wait for a processor.
    call(server.port(), "DELETE", "/v1/jobs/" + id, "", fields);
  }
  throw std::runtime_error("the job ends too early");
}

inline std::string code_of(const Answer& answer) {
  const auto json = nlohmann::json::parse(answer.body, nullptr, false);
  return json.is_object() ? json.value("code", "") : "";
}

/// Watches how much of the machine is taken by anything but the test and its server, if it has one.
class Neighbours {
 public:
  explicit Neighbours(std::optional<pid_t> server = {}) : server_(server), begin_(read()) {}
  /// The share of all processors' time that others had so far; those who run a machine for others count, too.
  double share() const {
    const Times now = read();
    const double all = now.all - begin_.all;
    return all <= 0 ? 0 : std::max(0.0, (now.busy - begin_.busy) - (now.ours - begin_.ours)) / all;
  }

 private:
  /// In ticks.
  struct Times {
    double all = 0;
    double busy = 0;
    double ours = 0;
  };
  Times read() const {
    Times times;
    std::ifstream machine("/proc/stat");
    std::string word;
    machine >> word;
    // user nice system idle iowait irq softirq steal; what follows is counted in these.
    for (int i = 0; i < 8; ++i) {
      double ticks = 0;
      machine >> ticks;
      times.all += ticks;
      if (i != 3 && i != 4) times.busy += ticks;
    }
    times.ours = ours("self") + (server_ ? ours(std::to_string(*server_)) : 0);
    return times;
  }
  /// Of a process, and of its children that have ended.
  static double ours(const std::string& process) {
    std::ifstream file("/proc/" + process + "/stat");
    std::string text;
    std::getline(file, text);
    std::istringstream fields(text.substr(std::min(text.size(), text.rfind(')') + 1)));
    std::string skipped;
    for (int i = 0; i < 11; ++i) fields >> skipped;
    double sum = 0;
    for (double ticks = 0, i = 0; i < 4 && fields >> ticks; ++i) sum += ticks;
    return sum;
  }
  std::optional<pid_t> server_;
  Times begin_;
};

/// The most memory that the process has had, in MB.
inline double peak_megabytes(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1000;
  }
  return 0;
}

}  // namespace surfaced::testing
