// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/ogc_json.hpp"

#include <array>

#include "api/job_json.hpp"
#include "api/outputs.hpp"
#include "http/problem.hpp"
#include "platform/base64.hpp"

namespace surfaced::api::ogc {
namespace {

constexpr std::string_view kCloudPath = "/v1/clouds/";
constexpr const char* kConformance = "http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf/";
constexpr const char* kExceptions = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/";

Json link(const char* rel, std::string href, const char* title) {
  return {{"rel", rel}, {"href", std::move(href)}, {"type", "application/json"}, {"title", title}};
}

std::string process_path(const MethodInfo& method) { return "/processes/" + method.id; }
std::string ogc_job_path(const Job& job) { return "/jobs/" + job.id; }

Json binary_schema(std::string_view media_type) {
  return {{"type", "string"}, {"contentEncoding", "binary"}, {"contentMediaType", media_type}};
}

Error wrong(std::string_view field, const Json& value, std::string_view allowed) {
  return http::wrong_value(ErrorCode::invalid_request, field, http::text_of(value), allowed);
}

/// Reads the input `cloud`: a link to a stored cloud, its id, or its bytes in base64.
Status read_cloud(const Json& input, Execution& execution) {
  constexpr std::string_view kTaken = "{\"href\": \"/v1/clouds/ID\"}, the id of a stored cloud, or {\"value\": BASE64}";
  if (input.is_string()) {
    execution.submission["cloud_id"] = input;
    return Done{};
  }
  if (!input.is_object()) return wrong("inputs.cloud", input, kTaken);
  const auto href = input.find("href");
  const auto value = input.find("value");
  if (href != input.end() && value != input.end()) {
    return with_fault({ErrorCode::conflicting_input, "inputs.cloud has both href and value"},
                      {"inputs.cloud", "href and value", "one of them"});
  }
  if (href != input.end() && href->is_string()) {
    const auto text = href->get<std::string>();
    const std::size_t at = text.find(kCloudPath);
    if (at == text.npos) return wrong("inputs.cloud.href", *href, "a stored cloud, /v1/clouds/ID");
    execution.submission["cloud_id"] = text.substr(at + kCloudPath.size());
    return Done{};
  }
  if (value == input.end() || !value->is_string()) return wrong("inputs.cloud", input, kTaken);
  auto bytes = base64_decode(value->get<std::string>());
  if (!bytes || bytes->empty()) return wrong("inputs.cloud.value", *value, "a cloud in base64");
  execution.cloud = std::move(*bytes);
  return Done{};
}

Status read_inputs(const Json& body, Execution& execution) {
  const auto inputs = body.find("inputs");
  if (inputs == body.end()) return http::missing_value(ErrorCode::invalid_request, "inputs", "an object with a cloud");
  if (!inputs->is_object()) return wrong("inputs", *inputs, "an object with a cloud");
  Json parameters = Json::object();
  bool has_cloud = false;
  for (const auto& [name, value] : inputs->items()) {
    if (name != "cloud") {
      parameters[name] = value;
      continue;
    }
    has_cloud = true;
    if (Status read = read_cloud(value, execution); !read.ok()) return read;
  }
  if (!has_cloud) {
    return http::missing_value(ErrorCode::invalid_request, "inputs.cloud",
                               "a link to a stored cloud, its id, or its bytes");
  }
  execution.submission["parameters"] = std::move(parameters);
  return Done{};
}

/// Reads `format`, and `transmissionMode` whose default is value.
Status read_output(const std::string& name, const Json& wanted, Execution& execution) {
  const std::string field = "outputs." + name;
  if (!wanted.is_object()) return wrong(field, wanted, "an object");
  Presentation::Wanted output{name, false};
  if (const auto mode = wanted.find("transmissionMode"); mode != wanted.end()) {
    if (*mode != "value" && *mode != "reference")
      return wrong(field + ".transmissionMode", *mode, "value or reference");
    output.by_reference = *mode == "reference";
  }
  execution.presentation.outputs.push_back(std::move(output));
  const auto format = wanted.find("format");
  if (format == wanted.end()) return Done{};
  if (!format->is_object() || !format->contains("mediaType") || !format->at("mediaType").is_string()) {
    return wrong(field + ".format", *format, "an object with a mediaType");
  }
  const auto type = format->at("mediaType").get<std::string>();
  if (name == "report") {
    if (type == media_type_of("report.json")) return Done{};
    return http::wrong_value(ErrorCode::not_acceptable, field + ".format.mediaType", type,
                             media_type_of("report.json"));
  }
  const auto chosen = negotiate_mesh(type, {});
  if (!chosen) {
    return http::wrong_value(ErrorCode::not_acceptable, field + ".format.mediaType", type,
                             chosen.error().fault->allowed);
  }
  execution.submission["outputs"] = Json::array({*chosen});
  return Done{};
}

Status read_outputs(const Json& body, Execution& execution) {
  auto& wanted = execution.presentation.outputs;
  const auto outputs = body.find("outputs");
  // Whoever names none wants all of them, as such.
  wanted = {{"mesh", false}, {"report", false}};
  if (outputs == body.end() || outputs->is_null()) return Done{};
  if (!outputs->is_object()) return wrong("outputs", *outputs, "an object");
  if (outputs->empty()) return Done{};
  wanted.clear();
  for (const auto& [name, each] : outputs->items()) {
    if (name != "mesh" && name != "report") {
      return http::wrong_value(ErrorCode::unknown_output, "outputs", name, "mesh, report");
    }
    if (Status read = read_output(name, each, execution); !read.ok()) return read;
  }
  return Done{};
}

}  // namespace

Json conformance() {
  Json classes = Json::array();
  for (const char* each : {"core", "ogc-process-description", "json", "oas30", "job-list", "dismiss"}) {
    classes.push_back(std::string(kConformance) + each);
  }
  return {{"conformsTo", std::move(classes)}};
}

Json process_summary(const MethodInfo& method) {
  return {{"id", method.id},
          {"title", method.title},
          {"description", method.summary},
          {"version", version()},
          {"jobControlOptions", {"sync-execute", "async-execute", "dismiss"}},
          {"outputTransmission", {"value", "reference"}},
          {"links",
           {link("self", process_path(method), "Description of the process"),
            link("http://www.opengis.net/def/rel/ogc/1.0/execute", process_path(method) + "/execution", "Execute")}}};
}

Json process_description(const MethodInfo& method) {
  Json process = process_summary(method);
  Json& inputs = process["inputs"] = Json::object();
  inputs["cloud"] = {
      {"title", "Point cloud"},
      {"description", "href of a stored cloud (/v1/clouds/{id}), its id, or its bytes in base64 as value."},
      {"minOccurs", 1},
      {"maxOccurs", 1},
      {"schema", binary_schema("application/octet-stream")}};
  for (const auto& [name, schema] : method.parameters.at("properties").items()) {
    inputs[name] = {{"title", schema.value("title", name)},
                    {"description", schema.value("description", "")},
                    {"minOccurs", 0},
                    {"maxOccurs", 1},
                    {"schema", schema}};
  }
  Json meshes = Json::array();
  for (const OutputKind& kind : mesh_kinds()) meshes.push_back(binary_schema(kind.media_type));
  process["outputs"] = {{"mesh", {{"title", "Mesh"}, {"schema", {{"anyOf", std::move(meshes)}}}}},
                        {"report", {{"title", "Report"}, {"schema", {{"type", "object"}}}}}};
  return process;
}

Json status_info(const Job& job) {
  const auto time = [](const std::optional<SystemTime>& when) { return when ? Json(to_rfc3339(*when)) : Json(); };
  Json info{{"processID", job.method},
            {"type", "process"},
            {"jobID", job.id},
            {"status", name_of(job.status)},
            {"created", to_rfc3339(job.created_at)}};
  if (job.error) info["message"] = job.error->detail;
  if (job.started_at) info["started"] = time(job.started_at);
  if (job.finished_at) info["finished"] = time(job.finished_at);
  info["updated"] = to_rfc3339(job.finished_at.value_or(job.started_at.value_or(job.created_at)));
  info["progress"] = static_cast<int>(job.progress * 100);
  info["links"] = Json::array({link("self", ogc_job_path(job), "This job"),
                               link("alternate", job_path(job.id), "The same job in the service's own words")});
  if (job.status == JobStatus::successful) {
    info["links"].push_back(
        link("http://www.opengis.net/def/rel/ogc/1.0/results", ogc_job_path(job) + "/results", "Results"));
  }
  return info;
}

std::string text_of(const Presentation& presentation) {
  Json outputs = Json::array();
  for (const auto& wanted : presentation.outputs) {
    outputs.push_back({{"output", wanted.output}, {"by_reference", wanted.by_reference}});
  }
  return Json{{"raw", presentation.raw}, {"outputs", std::move(outputs)}}.dump();
}

Presentation presentation_of(const Job& job) {
  const Json json = Json::parse(job.presentation, nullptr, false);
  if (!json.is_object()) return {};
  Presentation presentation{json.value("raw", false), {}};
  for (const Json& each : json.at("outputs")) {
    presentation.outputs.push_back({each.at("output").get<std::string>(), each.at("by_reference").get<bool>()});
  }
  return presentation;
}

std::string output_name(const Job& job, std::string_view output) {
  return output == "report" ? "report.json" : job.wanted.front();
}

Result<Execution> read_execution(const Json& body, const MethodInfo& method) {
  if (!body.is_object()) return wrong("body", body, "an object");
  Execution execution;
  execution.submission = {{"method", method.id}};
  if (Status read = read_inputs(body, execution); !read.ok()) return read.error();
  if (Status read = read_outputs(body, execution); !read.ok()) return read.error();
  execution.presentation.raw = true;
  if (const auto response = body.find("response"); response != body.end() && !response->is_null()) {
    if (*response != "raw" && *response != "document") return wrong("response", *response, "raw or document");
    execution.presentation.raw = *response == "raw";
  }
  const auto subscriber = body.find("subscriber");
  if (subscriber == body.end() || subscriber->is_null()) return execution;
  if (!subscriber->is_object()) return wrong("subscriber", *subscriber, "an object with a successUri");
  if (subscriber->contains("successUri")) execution.submission["webhook"] = subscriber->at("successUri");
  return execution;
}

http::Response problem(const Error& error, const http::Request& request) {
  http::Response response = http::problem_response(error, request);
  const char* type = nullptr;
  switch (error.code) {
    case ErrorCode::method_not_found:
      type = "no-such-process";
      break;
    case ErrorCode::job_not_found:
    case ErrorCode::job_gone:
      type = "no-such-job";
      break;
    case ErrorCode::result_not_ready:
      type = "result-not-ready";
      break;
    default:
      return response;
  }
  http::Json json = http::problem_json(error, request.path, request.request_id);
  json["type"] = std::string(kExceptions) + type;
  response.body = http::text_of(json);
  return response;
}

}  // namespace surfaced::api::ogc
