// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/routes.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using Json = nlohmann::ordered_json;

Json delivery_json(const Delivery& delivery) {
  const auto time = [](const std::optional<SystemTime>& when) { return when ? Json(to_rfc3339(*when)) : Json(); };
  return {{"id", delivery.id},
          {"url", delivery.url},
          {"status", delivery.status},
          {"attempts", delivery.attempts},
          {"created_at", to_rfc3339(delivery.created_at)},
          {"next_at", time(delivery.next_at)},
          {"tried_at", time(delivery.tried_at)},
          {"http_status", delivery.http_status == 0 ? Json() : Json(delivery.http_status)},
          {"detail", delivery.detail.empty() ? Json() : Json(delivery.detail)}};
}

http::Response list_deliveries(const http::Request& request, JobService& service, DeliveryStore& deliveries) {
  const std::string& id = request.path_parts.at("id");
  if (const auto job = service.find(id); !job) return http::problem_response(job.error(), request);
  const auto found = deliveries.of_job(id);
  if (!found) return http::problem_response(found.error(), request);
  Json list = Json::array();
  for (const Delivery& each : *found) list.push_back(delivery_json(each));
  return http::json_response(200, {{"deliveries", std::move(list)}});
}

}  // namespace

void add_delivery_routes(http::Router& router, JobService& service, DeliveryStore& deliveries) {
  router.add("GET", "/v1/jobs/{id}/deliveries",
             [&service, &deliveries](http::Request& request) { return list_deliveries(request, service, deliveries); });
}

}  // namespace surfaced::api
