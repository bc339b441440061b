// What tests of the running service do again and again.
#pragma once

#include <chrono>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/base.hpp"
#include "support/http_client.hpp"
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

inline nlohmann::json job_of(std::uint16_t port, const std::string& id, const std::string& query = "") {
  return nlohmann::json::parse(call(port, "GET", "/v1/jobs/" + id + query).body);
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

/// The job once it runs (or has ended), or as it is after half a minute.
inline nlohmann::json wait_for_start(std::uint16_t port, const std::string& id) {
  nlohmann::json now = job_of(port, id);
  for (int i = 0; i < 1500 && now.at("status") == "accepted"; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    now = job_of(port, id);
  }
  return now;
}

inline std::string code_of(const Answer& answer) {
  const auto json = nlohmann::json::parse(answer.body, nullptr, false);
  return json.is_object() ? json.value("code", "") : "";
}

/// The most memory that the process has had, in MB.
inline double peak_megabytes(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1000;
  }
  return 0;
}

}  // namespace surfaced::testing
