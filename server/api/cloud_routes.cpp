// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/intake.hpp"
#include "api/routes.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using http::problem_response;
using http::Request;
using http::Response;
using Json = nlohmann::ordered_json;

std::string cloud_path(const std::string& id) { return "/v1/clouds/" + id; }

Json cloud_json(const Cloud& cloud, std::chrono::seconds kept) {
  const auto fact = [&](const char* name) {
    return cloud.facts.is_object() && cloud.facts.contains(name) ? cloud.facts.at(name) : Json();
  };
  return {{"id", cloud.id},
          {"bytes", cloud.bytes},
          {"status", name_of(cloud.status)},
          {"created_at", to_rfc3339(cloud.created_at)},
          {"expires_at", kept.count() == 0 ? Json() : Json(to_rfc3339(cloud.used_at + kept))},
          {"points", fact("points")},
          {"distinct_points", fact("distinct_points")},
          {"bounds", fact("bounds")},
          {"attributes", fact("attributes")},
          {"warnings", fact("warnings")},
          {"error", cloud.error ? http::problem_json(*cloud.error, cloud_path(cloud.id), "") : Json()},
          {"links", Json::array({{{"rel", "self"}, {"href", cloud_path(cloud.id)}, {"type", "application/json"}}})}};
}

Response store_cloud(Request& request, JobService& service, CloudService& clouds, std::chrono::seconds kept) {
  if (!request.query.empty()) {
    const auto& [name, value] = request.query.front();
    return problem_response(with_fault({ErrorCode::unknown_parameter, "'" + name + "' is not taken by this path"},
                                       {name, value, "no query"}),
                            request);
  }
  const std::string type = content_type_of(request);
  if (type == "application/json" || type == "multipart/form-data") {
    return problem_response(http::wrong_value(ErrorCode::unsupported_media_type, "Content-Type", type,
                                              "application/octet-stream, the raw bytes of a cloud"),
                            request);
  }
  const auto upload = receive_raw(request, service);
  if (!upload) return problem_response(upload.error(), request);
  const auto added = clouds.add(**upload, request.caller.id, allowance_of(request.caller));
  if (!added) return problem_response(added.error(), request);
  Response response = http::json_response(added->created ? 201 : 200, cloud_json(added->cloud, kept));
  response.headers.add("Location", cloud_path(added->cloud.id));
  return response;
}

Response get_cloud(const Request& request, CloudService& clouds, std::chrono::seconds kept) {
  const auto cloud = clouds.find(request.path_parts.at("id"), request.caller.owner());
  return cloud ? http::json_response(200, cloud_json(*cloud, kept)) : problem_response(cloud.error(), request);
}

Response delete_cloud(const Request& request, CloudService& clouds) {
  const Status removed = clouds.remove(request.path_parts.at("id"), request.caller.owner());
  if (!removed) return problem_response(removed.error(), request);
  Response response;
  response.status = 204;
  return response;
}

}  // namespace

void add_cloud_routes(http::Router& router, JobService& service, CloudService& clouds, std::chrono::seconds kept) {
  router.add("POST", "/v1/clouds",
             [&service, &clouds, kept](Request& request) { return store_cloud(request, service, clouds, kept); });
  router.add("GET", "/v1/clouds/{id}", [&clouds, kept](Request& request) { return get_cloud(request, clouds, kept); });
  router.add("DELETE", "/v1/clouds/{id}", [&clouds](Request& request) { return delete_cloud(request, clouds); });
}

}  // namespace surfaced::api
