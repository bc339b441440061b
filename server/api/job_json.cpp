// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/job_json.hpp"

#include "api/outputs.hpp"
#include "base/sha256.hpp"
#include "http/problem.hpp"
#include "platform/files.hpp"

namespace surfaced::api {
namespace {

using Json = nlohmann::ordered_json;

Json time_json(const std::optional<SystemTime>& time) { return time ? Json(to_rfc3339(*time)) : Json(); }

Json links_json(const Job& job) {
  Json links = Json::array({Json{{"rel", "self"}, {"href", job_path(job.id)}, {"type", "application/json"}}});
  for (const Output& output : job.outputs) {
    if (media_type_of(output.name).empty()) continue;
    links.push_back(Json{{"rel", "item"},
                         {"href", output_path(job.id, output.name)},
                         {"type", media_type_of(output.name)},
                         {"title", output.name}});
  }
  return links;
}

Json attempts_json(const Job& job) {
  Json list = Json::array();
  for (const Attempt& attempt : job.attempts) {
    list.push_back({{"number", attempt.number},
                    {"started_at", to_rfc3339(attempt.started_at)},
                    {"ended_at", time_json(attempt.ended_at)},
                    {"outcome", attempt.outcome.empty() ? Json() : Json(attempt.outcome)},
                    {"seconds", attempt.usage.seconds},
                    {"cpu_seconds", attempt.usage.cpu_seconds},
                    {"peak_memory_bytes", attempt.usage.peak_memory_bytes},
                    {"code", attempt.error ? Json(name_of(attempt.error->code)) : Json()},
                    {"detail", attempt.error ? Json(attempt.error->detail) : Json()}});
  }
  return list;
}

}  // namespace

std::string job_path(std::string_view id) { return "/v1/jobs/" + std::string(id); }

std::string output_path(std::string_view id, std::string_view output) {
  return job_path(id) + "/outputs/" + std::string(output);
}

Json job_json(const Job& job) {
  return {{"id", job.id},
          {"method", job.method},
          {"parameters", job.parameters},
          {"outputs", job.wanted},
          {"status", name_of(job.status)},
          {"progress", job.progress},
          {"phase", job.phase.empty() ? Json() : Json(job.phase)},
          {"queue_position", job.queue_position ? Json(*job.queue_position) : Json()},
          {"attempt", job.attempt},
          {"attempts", attempts_json(job)},
          {"parked", job.parked},
          {"created_at", to_rfc3339(job.created_at)},
          {"started_at", time_json(job.started_at)},
          {"finished_at", time_json(job.finished_at)},
          {"expires_at", time_json(job.expires_at)},
          {"error", job.error ? http::problem_json(*job.error, job_path(job.id), job.request_id) : Json()},
          {"labels", job.labels},
          {"cloud_id", job.of_stored_cloud() ? Json(job.input.key) : Json()},
          {"links", links_json(job)}};
}

std::string job_etag(const Job& job) {
  Sha256 sha;
  sha.update(as_bytes(http::text_of(job_json(job))));
  return "\"" + sha.finish().substr(0, 32) + "\"";
}

}  // namespace surfaced::api
