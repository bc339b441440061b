// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/routes.hpp"
#include "http/assembly.hpp"
#include "http/problem.hpp"
#include "proto/embedded.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced::api {
namespace {

using http::json_response;
using http::problem_response;
using http::Request;
using http::Response;

Json probe() { return {{"status", "ok"}, {"version", version()}}; }

Response index(const Request& /*request*/) {
  const auto link = [](const char* rel, const char* href, const char* title) {
    return Json{{"rel", rel}, {"href", href}, {"type", "application/json"}, {"title", title}};
  };
  Json older = link("service-desc", "/openapi-3.0.json", "The contract, OpenAPI 3.0");
  older["type"] = "application/vnd.oai.openapi+json;version=3.0";
  Json docs = link("service-doc", "/docs", "The contract for people");
  docs["type"] = "text/html";
  return json_response(
      200,
      {{"name", "surfaced"},
       {"title", "surfaced"},
       {"version", version()},
       {"description", "Turns point clouds into meshes."},
       {"links",
        Json::array({link("self", "/", "This page"), link("service-desc", "/openapi.json", "The contract, OpenAPI 3.1"),
                     std::move(older), link("methods", "/v1/methods", "The methods and their parameters"),
                     link("reconstruct", "/v1/reconstruct", "POST a cloud, get a mesh"),
                     link("jobs", "/v1/jobs", "POST a cloud, get a job"), std::move(docs),
                     link("conformance", "/conformance", "OGC API - Processes"),
                     link("http://www.opengis.net/def/rel/ogc/1.0/conformance", "/conformance", "OGC API - Processes"),
                     link("http://www.opengis.net/def/rel/ogc/1.0/processes", "/processes", "The methods as processes"),
                     link("http://www.opengis.net/def/rel/ogc/1.0/job-list", "/jobs",
                          "The jobs, as OGC API - Processes sees them")})}});
}

Response get_method(const Request& request) {
  const auto method = find_method(request.path_parts.at("id"));
  if (!method) {
    return problem_response({ErrorCode::method_not_found, method.error().detail, method.error().fault}, request);
  }
  return json_response(200, method_json(**method));
}

Response file(const char* content_type, std::string_view bytes) {
  Response response;
  response.content_type = content_type;
  response.body = http::body_of_static(bytes);
  return response;
}

Response documentation(const Request& /*request*/) {
  Response response = file("text/html; charset=utf-8", proto::docs_html());
  // The page loads nothing from elsewhere, runs nothing that stands in it, and is shown in no other page.
  response.headers.add("Content-Security-Policy",
                       "default-src 'none'; connect-src 'self'; style-src 'self'; script-src 'self'; base-uri 'none'; "
                       "form-action 'none'; frame-ancestors 'none'");
  // For browsers that do not know frame-ancestors.
  response.headers.add("X-Frame-Options", "DENY");
  return response;
}

}  // namespace

void add_info_routes(http::Router& router, JobService& service, const RouteOptions& options) {
  add_viewer_routes(router, index);
  router.add("GET", "/openapi.json", [](Request&) { return file("application/json", proto::openapi_json()); });
  router.add("GET", "/docs", documentation);
  router.add("GET", "/docs.css", [](Request&) { return file("text/css; charset=utf-8", proto::docs_css()); });
  router.add("GET", "/docs.js", [](Request&) { return file("text/javascript; charset=utf-8", proto::docs_js()); });
  router.add("GET", "/v1/methods", [](Request&) { return json_response(200, {{"methods", methods_json()}}); });
  router.add("GET", "/v1/methods/{id}", get_method);
  router.add("GET", "/healthz", [](Request&) { return json_response(200, probe()); });
  router.add("GET", "/metrics", [metrics = options.metrics](Request&) {
    Response response;
    response.content_type = "text/plain; version=0.0.4; charset=utf-8";
    response.headers.add("Cache-Control", "no-store");
    response.body = metrics();
    return response;
  });
  router.add("GET", "/readyz", [&service](Request& request) {
    const Status ready = service.ready();
    if (ready) return json_response(200, probe());
    return problem_response({ErrorCode::not_ready, ready.error().detail}, request);
  });
}

void add_routes(http::Router& router, JobService& service, CloudService& clouds, UploadFinishing& uploads,
                const RouteOptions& options) {
  add_submit_routes(router, service, options);
  add_job_routes(router, service, options);
  add_event_routes(router, service, options);
  add_ogc_routes(router, service, options);
  add_cloud_routes(router, service, clouds, options.cloud_time);
  add_upload_routes(router, service, uploads, options.body_bytes);
  add_output_routes(router, service, options);
  add_info_routes(router, service, options);
}

}  // namespace surfaced::api
