// SPDX-License-Identifier: GPL-3.0-or-later
// Turns a point cloud into a mesh with a surfaced server: cpp-httplib and nlohmann-json.
#include <httplib.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <thread>

namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* kUsage = R"(usage: reconstruct_client CLOUD MESH.glb [name=value...]

Uploads the cloud, follows the job, downloads the mesh and prints its quality.
name=value: method=ID and the method's parameters.
SURFACED_URL is the server (default http://127.0.0.1:8080), SURFACED_KEY the key, if it wants one.
)";
constexpr int kTries = 5;

std::string variable(const char* name, const char* otherwise) {
  const char* value = std::getenv(name);
  return value ? value : otherwise;
}

/// A problem in words; what does not speak JSON is a proxy in between.
std::string said(const httplib::Response& answer) {
  const Json problem = Json::parse(answer.body, nullptr, false);
  if (!problem.is_object()) return std::to_string(answer.status) + " " + answer.reason;
  return problem.value("title", "") + ": " + problem.value("detail", "") + ". " + problem.value("hint", "");
}

/// Tries again what may pass: no connection, a lost answer, 429 and 503. Throws what is refused.
httplib::Response request(const std::function<httplib::Result()>& send) {
  std::string reason;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    std::chrono::milliseconds pause(500 << attempt);
    const httplib::Result answer = send();
    if (answer && answer->status < 400) return *answer;
    reason = answer ? said(*answer) : to_string(answer.error());
    const int status = answer ? answer->status : 503;
    if (status != 429 && (status < 502 || status > 504)) throw std::runtime_error(reason);
    if (answer && answer->has_header("Retry-After")) {
      pause = std::chrono::seconds(std::atoi(answer->get_header_value("Retry-After").c_str()));
    }
    std::cerr << reason << "; trying again in " << pause.count() << " ms\n";
    std::this_thread::sleep_for(pause);
  }
  throw std::runtime_error("given up after " + std::to_string(kTries) + " tries; the last said: " + reason);
}

/// The job that the cloud became. The Idempotency-Key lets a submission whose answer was lost be repeated: it makes no
/// second job.
Json submit(httplib::Client& server, const fs::path& cloud, const std::string& query) {
  const std::size_t size = fs::file_size(cloud);
  const httplib::Headers once{
      {"Idempotency-Key", std::to_string(std::random_device()()) + std::to_string(std::random_device()())}};
  const auto answer = request([&] {
    std::ifstream file(cloud, std::ios::binary);
    std::vector<char> piece(std::size_t{1} << 16);
    const auto provide = [&](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
      const std::size_t count = std::min(length, piece.size());
      if (!file.read(piece.data(), static_cast<std::streamsize>(count))) return false;
      std::cerr << "upload " << 100 * (offset + count) / size << " %\n";
      return sink.write(piece.data(), count);
    };
    return server.Post("/v1/jobs?" + query, once, size, provide, "application/octet-stream");
  });
  return Json::parse(answer.body);
}

/// Follows the job's events until `done`; where the stream breaks off, a new one goes on.
Json follow(httplib::Client& server, const std::string& path) {
  std::string event;
  std::string last;
  Json job;
  const auto take = [&](const std::string& line) {
    const std::string name = line.substr(0, line.find(": "));
    const std::string value = line.substr(std::min(line.size(), name.size() + 2));
    if (name == "event") event = value;
    if (name == "id") last = value;
    if (name == "data" && event == "progress") {
      const Json data = Json::parse(value);
      std::cerr << data["phase"] << " " << 100 * data["progress"].get<double>() << " %\n";
    }
    if (name == "data" && event == "done") job = Json::parse(value);
  };
  while (job.is_null()) {
    std::string text;
    request([&] {
      const auto headers = last.empty() ? httplib::Headers{} : httplib::Headers{{"Last-Event-ID", last}};
      auto answer = server.Get(path, headers, [&](const char* data, std::size_t size) {
        text.append(data, size);
        for (std::size_t end = text.find('\n'); end != text.npos; end = text.find('\n')) {
          take(text.substr(0, end));
          text.erase(0, end + 1);
        }
        return true;
      });
      if (answer && answer->status >= 400) answer->body = text;  // a problem instead of events
      return answer;
    });
  }
  return job;
}

Json reconstruct(const fs::path& cloud, const fs::path& mesh, const std::string& query) {
  httplib::Client server(variable("SURFACED_URL", "http://127.0.0.1:8080"));
  server.set_read_timeout(std::chrono::seconds(60));
  if (const std::string key = variable("SURFACED_KEY", ""); !key.empty()) server.set_bearer_token_auth(key);
  Json job = submit(server, cloud, query);
  const std::string path = "/v1/jobs/" + job["id"].get<std::string>();
  job = follow(server, path + "/events");
  if (job.value("status", "") != "successful") {
    throw std::runtime_error(job["error"].is_object() ? job["error"].value("detail", "") : "the job was dismissed");
  }
  const fs::path part = mesh.string() + ".part";
  std::ofstream(part, std::ios::binary) << request([&] { return server.Get(path + "/outputs/mesh.glb"); }).body;
  fs::rename(part, mesh);
  return Json::parse(request([&] { return server.Get(path + "/outputs/report.json"); }).body);
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const bool help = !arguments.empty() && arguments[0] == "--help";
  if (help || arguments.size() < 2) return (help ? std::cout : std::cerr) << kUsage, help ? 0 : 2;
  std::string query;
  for (std::size_t i = 2; i < arguments.size(); ++i) query += (i > 2 ? "&" : "") + arguments[i];
  const Json report = reconstruct(arguments[0], arguments[1], query);
  const Json& mesh = report["mesh"];
  const Json& shape = report["quality"]["shortest_edge_to_circumradius"];
  std::cout << mesh["vertices"] << " vertices, " << mesh["triangles"] << " triangles, genus " << mesh["genus"]
            << ", closed: " << mesh["closed"] << "\nshortest edge / circumradius: min " << shape["min"] << ", mean "
            << shape["mean"] << " (equilateral: 1.732)\nunused points: " << report["quality"]["unused_points"] << "\n";
} catch (const std::exception& failure) {
  std::cerr << "reconstruct_client: " << failure.what() << "\n";
  return 1;
}
