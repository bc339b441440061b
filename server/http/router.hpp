// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "http/message.hpp"

namespace surfaced::http {

using Handler = std::function<Response(Request&)>;

/// What stands between the routing and every handler.
class RequestFilter {
 public:
  RequestFilter() = default;
  RequestFilter(const RequestFilter&) = delete;
  RequestFilter& operator=(const RequestFilter&) = delete;
  virtual ~RequestFilter() = default;

  /// The answer to a preflight request of a browser; none if the request is none.
  virtual std::optional<Response> preflight(const Request& request) const = 0;
  /// Why the handler is not called, if it is not; fills in the caller.
  virtual std::optional<Response> refuse(Request& request, std::string_view route) = 0;
  /// Adds to every answer what browsers need.
  virtual void decorate(const Request& request, Response& response) const = 0;
};

/// Finds the handler of a request by its method and path. A handler for GET answers HEAD too.
class Router {
 public:
  /// @param pattern  path whose parts in braces match one part each: /v1/jobs/{id}
  void add(std::string method, std::string_view pattern, Handler handler);

  /// From now on every request passes it. It has to outlive the router.
  void set_filter(RequestFilter& filter) { filter_ = &filter; }

  /// Calls the handler, or answers not_found, or method_not_allowed with Allow. Whatever a handler throws
  /// becomes an internal_error that says nothing of it.
  Response handle(Request& request) const;

 private:
  struct Route {
    std::string method;
    std::string pattern;
    std::vector<std::string> parts;
    Handler handler;
  };
  Response dispatch(Request& request) const;
  Response guarded(Request& request) const;
  std::vector<Route> routes_;
  RequestFilter* filter_ = nullptr;
};

}  // namespace surfaced::http
