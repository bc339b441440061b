// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/ogc_results.hpp"

#include <algorithm>
#include <vector>

#include "api/job_json.hpp"
#include "api/ogc_json.hpp"
#include "api/outputs.hpp"
#include "http/assembly.hpp"
#include "http/problem.hpp"

namespace surfaced::api::ogc {
namespace {

using http::BodyStream;
using Wanted = Presentation::Wanted;

/// In no output: an id of 128 random bits is part of it.
std::string boundary_of(const Job& job) { return "surfaced-" + job.id; }

std::string link_to(const Job& job, const Wanted& wanted) {
  const std::string name = output_name(job, wanted.output);
  return "<" + output_path(job.id, name) + ">; rel=\"item\"; title=\"" + wanted.output + "\"; type=\"" +
         std::string(media_type_of(name)) + "\"";
}

Result<BodyStream> open(const Job& job, const Wanted& wanted, JobService& service) {
  const std::string name = output_name(job, wanted.output);
  const auto output = std::ranges::find(job.outputs, name, &Output::name);
  if (output != job.outputs.end()) return service.open_output(job, *output);
  return Error{ErrorCode::internal_error, "job " + job.id + " has lost its output " + name};
}

/// A part of multipart/related (RFC 2387), its head before it.
Result<std::vector<BodyStream>> part_of(const Job& job, const Wanted& wanted, JobService& service) {
  const std::string name = output_name(job, wanted.output);
  std::string head = "--" + boundary_of(job) + "\r\nContent-ID: " + wanted.output +
                     "\r\nContent-Type: " + std::string(media_type_of(name)) + "\r\n";
  std::vector<BodyStream> parts;
  if (wanted.by_reference) {
    parts.push_back(http::body_of(head + "Content-Location: " + output_path(job.id, name) + "\r\n\r\n\r\n"));
    return parts;
  }
  auto body = open(job, wanted, service);
  if (!body) return std::move(body).error();
  parts.push_back(http::body_of(head + "Content-Length: " + std::to_string(body->length) + "\r\n\r\n"));
  parts.push_back(std::move(*body));
  parts.push_back(http::body_of("\r\n"));
  return parts;
}

/// A member of a document: a link, JSON as it is, or anything else in base64.
Result<std::vector<BodyStream>> member_of(const Job& job, const Wanted& wanted, JobService& service) {
  const std::string name = output_name(job, wanted.output);
  const std::string type(media_type_of(name));
  const std::string key = "\"" + wanted.output + "\":";
  std::vector<BodyStream> parts;
  if (wanted.by_reference) {
    parts.push_back(http::body_of(key + Json{{"href", output_path(job.id, name)}, {"type", type}}.dump()));
    return parts;
  }
  auto body = open(job, wanted, service);
  if (!body) return std::move(body).error();
  const bool json = wanted.output == "report";
  const std::string rest = ",\"mediaType\":\"" + type + "\"}";
  parts.push_back(http::body_of(key + (json ? "{\"value\":" : "{\"value\":\"")));
  parts.push_back(json ? std::move(*body) : http::base64_of(std::move(*body)));
  parts.push_back(http::body_of(json ? rest : "\",\"encoding\":\"base64\"" + rest));
  return parts;
}

Result<BodyStream> multipart(const Job& job, const std::vector<Wanted>& outputs, JobService& service) {
  std::vector<BodyStream> all;
  for (const Wanted& wanted : outputs) {
    auto parts = part_of(job, wanted, service);
    if (!parts) return std::move(parts).error();
    std::ranges::move(*parts, std::back_inserter(all));
  }
  all.push_back(http::body_of("--" + boundary_of(job) + "--\r\n"));
  return http::concatenated(std::move(all));
}

Result<BodyStream> document(const Job& job, const std::vector<Wanted>& outputs, JobService& service) {
  std::vector<BodyStream> all;
  for (const Wanted& wanted : outputs) {
    auto members = member_of(job, wanted, service);
    if (!members) return std::move(members).error();
    all.push_back(http::body_of(all.empty() ? "{" : ","));
    std::ranges::move(*members, std::back_inserter(all));
  }
  all.push_back(http::body_of("}"));
  return http::concatenated(std::move(all));
}

}  // namespace

http::Response results(const http::Request& request, const Job& job, JobService& service) {
  const Presentation presentation = presentation_of(job);
  const auto& outputs = presentation.outputs;
  http::Response response;
  response.headers.add("Cache-Control", "no-store");
  if (presentation.raw) {
    for (const Wanted& wanted : outputs) response.headers.add("Link", link_to(job, wanted));
  }
  if (presentation.raw && std::ranges::all_of(outputs, &Wanted::by_reference)) {
    response.status = 204;
    return response;
  }
  const bool single = outputs.size() == 1;
  auto body = !presentation.raw ? document(job, outputs, service)
              : single          ? open(job, outputs.front(), service)
                                : multipart(job, outputs, service);
  if (!body) return problem(body.error(), request);
  const std::string first(media_type_of(output_name(job, outputs.front().output)));
  response.content_type = !presentation.raw ? "application/json"
                          : single          ? first
                                            : "multipart/related; type=\"" + first + "\"; boundary=" + boundary_of(job);
  response.body = std::move(*body);
  return response;
}

}  // namespace surfaced::api::ogc
