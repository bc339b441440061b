#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "http/message.hpp"

namespace surfaced::http {

using Handler = std::function<Response(Request&)>;

/// Finds the handler of a request by its method and path. A handler for GET answers HEAD too.
class Router {
 public:
  /// @param pattern  path whose parts in braces match one part each: /v1/jobs/{id}
  void add(std::string method, std::string_view pattern, Handler handler);

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
  std::vector<Route> routes_;
};

}  // namespace surfaced::http
