// SPDX-License-Identifier: GPL-3.0-or-later
#include "access/access_filter.hpp"

#include <algorithm>
#include <array>
#include <iostream>

#include "access/client_address.hpp"
#include "http/problem.hpp"

namespace surfaced {
namespace {

using http::Request;
using http::Response;

constexpr std::chrono::seconds kLookAgain{1};

/// What is open to everybody: probes, the contract, and what the methods are.
constexpr auto kOpen = std::to_array<std::string_view>(
    {"/", "/healthz", "/readyz", "/openapi.json", "/openapi-3.0.json", "/docs", "/docs.css", "/docs.js",
     "/assets/{name}", "/samples", "/samples/{name}", "/licenses", "/conformance", "/v1/methods", "/v1/methods/{id}",
     "/processes", "/processes/{id}"});

/// Where something of the caller's is stored or queued.
bool takes_space(const Request& request, std::string_view route) {
  constexpr auto kRoutes = std::to_array<std::string_view>(
      {"/v1/reconstruct", "/v1/jobs", "/v1/clouds", "/v1/uploads", "/processes/{id}/execution", "/v1/jobs/{id}/retry"});
  return request.method == "POST" && std::ranges::find(kRoutes, route) != kRoutes.end();
}

bool queues_job(std::string_view route) { return route != "/v1/clouds" && route != "/v1/uploads"; }

bool is_open(const Request& request, std::string_view route) {
  return request.method == "OPTIONS" || std::ranges::find(kOpen, route) != kOpen.end();
}

std::string bearer_of(const Request& request) {
  const std::string_view value = request.headers.find("Authorization").value_or("");
  constexpr std::string_view kScheme = "Bearer ";
  if (value.size() > kScheme.size() && http::same_name(value.substr(0, kScheme.size()), kScheme)) {
    const std::string_view text = value.substr(kScheme.size());
    return std::string(text.substr(std::min(text.find_first_not_of(' '), text.size())));
  }
  return std::string(request.headers.find("X-Api-Key").value_or(""));
}

}  // namespace

Status AccessFilter::open() {
  if (rules_.keys.empty()) return Done{};
  auto loaded = KeyRing::load(rules_.keys);
  if (!loaded) return std::move(loaded).error();
  std::error_code ignored;
  changed_ = std::filesystem::last_write_time(rules_.keys, ignored);
  ring_ = std::make_shared<const KeyRing>(std::move(*loaded));
  looked_ = std::chrono::steady_clock::now();
  return Done{};
}

std::shared_ptr<const KeyRing> AccessFilter::ring() {
  const std::scoped_lock lock(mutex_);
  const auto time = std::chrono::steady_clock::now();
  if (time - looked_ < kLookAgain) return ring_;
  looked_ = time;
  std::error_code error;
  const auto changed = std::filesystem::last_write_time(rules_.keys, error);
  if (error || changed == changed_) return ring_;
  changed_ = changed;
  if (auto loaded = KeyRing::load(rules_.keys)) {
    ring_ = std::make_shared<const KeyRing>(std::move(*loaded));
  } else {
    // A file that is broken while somebody edits it locks nobody out, and lets nobody in.
    std::cerr << loaded.error().detail << "; the keys stay as they were" << std::endl;
  }
  return ring_;
}

std::optional<Response> AccessFilter::refuse(Request& request, std::string_view route) {
  request.remote_address = client_address(request.remote_address, request.headers, rules_.trusted_proxies);
  if (rules_.browsers) {
    if (const auto error = rules_.browsers->refuse(request)) return http::problem_response(*error, request);
  }
  if (is_open(request, route)) return std::nullopt;
  if (!rules_.keys.empty()) return check_key(request, route);
  if (is_loopback(request.remote_address)) return std::nullopt;
  return check_pace(request, route, client_group(request.remote_address), rules_.requests_per_minute,
                    rules_.submissions_per_minute);
}

std::optional<Response> AccessFilter::check_key(Request& request, std::string_view route) {
  const auto keys = ring();
  const std::string text = bearer_of(request);
  const Key* const key = keys->find(text);
  if (key == nullptr) {
    Response response = http::problem_response(
        {ErrorCode::unauthorized, text.empty() ? "the header Authorization: Bearer KEY is missing"
                                               : "the key is not known here; it may have been removed"},
        request);
    response.headers.add("WWW-Authenticate", "Bearer realm=\"surfaced\"");
    return response;
  }
  const Quota& quota = key->quota;
  request.caller = {key->id, key->scopes.admin, quota.active_jobs, quota.stored_bytes};
  auto slower = check_pace(request, route, key->id, quota.requests_per_minute, quota.submissions_per_minute);
  if (slower) return slower;
  if (const auto error = check_scope(request, *key, route)) return http::problem_response(*error, request);
  if (const auto error = check_owner(request, route)) return http::problem_response(*error, request);
  if (const auto error = check_quota(request, *key, route)) return http::problem_response(*error, request);
  return std::nullopt;
}

std::optional<Response> AccessFilter::check_pace(const Request& request, std::string_view route,
                                                 const std::string& client, std::uint64_t requests,
                                                 std::uint64_t submissions) {
  if (auto slower = count(request, client, "requests", requests)) return slower;
  if (!takes_space(request, route)) return std::nullopt;
  return count(request, "submissions of " + client, "submissions (clouds, uploads and jobs)", submissions);
}

std::optional<Response> AccessFilter::count(const Request& request, const std::string& client, const char* what,
                                            std::uint64_t per_minute) {
  if (per_minute == 0) return std::nullopt;
  const auto wait = pace_.take(client, per_minute, std::chrono::steady_clock::now());
  if (!wait) return std::nullopt;
  Response response = http::problem_response(
      {ErrorCode::too_many_requests, "the limit is " + std::to_string(per_minute) + " " + what + " a minute"}, request);
  response.headers.set("Retry-After", std::to_string(wait->count()));
  return response;
}

std::optional<Error> AccessFilter::check_scope(const Request& request, const Key& key, std::string_view route) const {
  const bool reads = request.method == "GET" || request.method == "HEAD";
  const char* needed = reads ? "read" : "submit";
  bool permitted = reads ? key.scopes.read : key.scopes.submit;
  if (route == "/metrics") {
    // They tell of everybody's jobs.
    needed = "metrics";
    permitted = key.scopes.metrics;
  }
  if (permitted) return std::nullopt;
  return Error{ErrorCode::forbidden, request.method + " " + request.path + " needs the scope " + needed + "; the key " +
                                         key.id + " has not got it"};
}

std::optional<Error> AccessFilter::check_owner(const Request& request, std::string_view route) {
  if (request.caller.all) return std::nullopt;
  if (!route.starts_with("/v1/jobs/{id}") && !route.starts_with("/jobs/{id}")) return std::nullopt;
  const auto owner = jobs_.owner_of(request.path_parts.at("id"));
  if (!owner) return owner.error();
  if (*owner == request.caller.id) return std::nullopt;
  // In the same words as for a job that there is not.
  return no_such_job(request.path_parts.at("id"));
}

std::optional<Error> AccessFilter::check_quota(const Request& request, const Key& key, std::string_view route) {
  const Allowance allowance{key.quota.active_jobs, key.quota.stored_bytes};
  if ((allowance.active_jobs == 0 && allowance.bytes == 0) || !takes_space(request, route)) return std::nullopt;
  const auto holding = jobs_.holding_of(key.id);
  if (!holding) return holding.error();
  const Status may = allowance.check(*holding, queues_job(route) ? 1 : 0, request.body->length().value_or(0));
  return may ? std::nullopt : std::optional(may.error());
}

bool AccessFilter::is_allowed(std::string_view origin) const {
  return std::ranges::any_of(rules_.cors_origins,
                             [&](const std::string& each) { return each == "*" || each == origin; });
}

std::optional<Response> AccessFilter::preflight(const Request& request) const {
  const auto origin = request.headers.find("Origin");
  if (request.method != "OPTIONS" || !origin || !request.headers.find("Access-Control-Request-Method")) return {};
  if (!is_allowed(*origin)) return {};
  Response response;
  response.status = 204;
  response.headers.add("Access-Control-Allow-Methods", "GET, HEAD, POST, PATCH, DELETE, OPTIONS");
  response.headers.add(
      "Access-Control-Allow-Headers",
      "Authorization, X-Api-Key, Content-Type, Accept, Idempotency-Key, If-None-Match, If-Range, Range, "
      "Last-Event-ID, Prefer, Tus-Resumable, Upload-Length, Upload-Offset, Upload-Metadata, "
      "Upload-Checksum, traceparent");
  response.headers.add("Access-Control-Max-Age", "600");
  return response;
}

void AccessFilter::decorate(const Request& request, Response& response) const {
  const auto origin = request.headers.find("Origin");
  if (rules_.cors_origins.empty()) return;
  response.headers.add("Vary", "Origin");
  if (!origin || !is_allowed(*origin)) return;
  response.headers.add("Access-Control-Allow-Origin", std::string(*origin));
  response.headers.add(
      "Access-Control-Expose-Headers",
      "Location, Content-Location, Link, ETag, Retry-After, Repr-Digest, Content-Range, Accept-Ranges, "
      "X-Request-Id, Preference-Applied, Tus-Resumable, Tus-Version, Tus-Extension, Tus-Max-Size, "
      "Tus-Checksum-Algorithm, Upload-Offset, Upload-Length, Upload-Metadata, Upload-Expires, "
      "Surfaced-Cloud-Id");
}

}  // namespace surfaced
