// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/router.hpp"

#include <exception>
#include <memory>
#include <new>

#include "base/text.hpp"
#include "http/problem.hpp"
#include "http/request_head.hpp"
#include "observability/log.hpp"

namespace surfaced::http {
namespace {

std::vector<std::string> split(std::string_view path) {
  std::vector<std::string> parts;
  while (path.starts_with('/')) {
    path.remove_prefix(1);
    parts.emplace_back(path.substr(0, path.find('/')));
    path.remove_prefix(parts.back().size());
  }
  return parts;
}

bool is_variable(std::string_view part) { return part.starts_with('{'); }

bool matches(const std::vector<std::string>& pattern, const std::vector<std::string>& parts) {
  if (pattern.size() != parts.size()) return false;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (is_variable(pattern[i]) ? parts[i].empty() : pattern[i] != parts[i]) return false;
  }
  return true;
}

}  // namespace

void Router::add(std::string method, std::string_view pattern, Handler handler) {
  routes_.push_back({std::move(method), std::string(pattern), split(pattern), std::move(handler)});
}

Response Router::handle(Request& request) const {
  try {
    return guarded(request);
  } catch (const std::bad_alloc&) {
    return problem_response({ErrorCode::not_ready, "the server is short of memory"}, request);
  } catch (const std::exception& failure) {
    log(LogLevel::error, "a handler failed", {{"request_id", request.request_id}, {"detail", failure.what()}});
    return problem_response({ErrorCode::internal_error, "the request could not be answered"}, request);
  }
}

Response Router::guarded(Request& request) const {
  if (filter_ == nullptr) return dispatch(request);
  auto preflight = filter_->preflight(request);
  Response response = preflight ? std::move(*preflight) : dispatch(request);
  if (!response.deferred) {
    filter_->decorate(request, response);
    return response;
  }
  auto deferred = std::make_shared<DeferredResponse>(*response.deferred);
  Request asked = request;
  asked.body = nullptr;
  deferred->poll = [look = std::move(deferred->poll), asked = std::move(asked), filter = filter_](bool last) {
    auto known = look(last);
    if (known) filter->decorate(asked, *known);
    return known;
  };
  response.deferred = std::move(deferred);
  return response;
}

Response Router::dispatch(Request& request) const {
  const auto parts = split(request.path);
  std::vector<std::string> allowed;
  for (const Route& route : routes_) {
    if (!matches(route.parts, parts)) continue;
    const bool as_get = request.method == "HEAD" && route.method == "GET";
    if (route.method != request.method && !as_get) {
      allowed.push_back(route.method);
      if (route.method == "GET") allowed.emplace_back("HEAD");
      continue;
    }
    request.route = route.pattern;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (!is_variable(route.parts[i])) continue;
      auto decoded = percent_decode(parts[i], false);
      if (!decoded) return problem_response(decoded.error(), request);
      request.path_parts[route.parts[i].substr(1, route.parts[i].size() - 2)] = std::move(*decoded);
    }
    if (filter_ != nullptr) {
      if (auto refused = filter_->refuse(request, route.pattern)) return std::move(*refused);
    }
    return route.handler(request);
  }
  if (allowed.empty()) {
    return problem_response({ErrorCode::not_found, "there is nothing at '" + request.path + "'"}, request);
  }
  const std::string others = joined(allowed);
  Response response = problem_response(
      {ErrorCode::method_not_allowed, request.method + " is not taken at '" + request.path + "', but " + others},
      request);
  response.headers.add("Allow", others);
  return response;
}

}  // namespace surfaced::http
