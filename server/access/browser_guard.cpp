// SPDX-License-Identifier: GPL-3.0-or-later
#include "access/browser_guard.hpp"

#include <algorithm>

#include "http/problem.hpp"
#include "platform/network.hpp"

namespace surfaced {
namespace {

/// Of host:port or [address]:port, without brackets.
std::string_view name_in(std::string_view authority) {
  if (authority.starts_with('[')) return authority.substr(1, std::min(authority.find(']'), authority.size()) - 1);
  return authority.substr(0, authority.find(':'));
}

/// The host of scheme://host:port; empty for `null`.
std::string_view host_of_origin(std::string_view origin) {
  const std::size_t scheme = origin.find("://");
  return scheme == origin.npos ? std::string_view() : name_in(origin.substr(scheme + 3));
}

bool holds(const std::vector<std::string>& list, std::string_view text) {
  return std::ranges::any_of(list, [&](const std::string& each) { return each == "*" || http::same_name(each, text); });
}

bool ends_with_name(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && http::same_name(text.substr(text.size() - end.size()), end);
}

/// Somebody follows a link to the page here: nothing is changed, and the page that has the link sees nothing of it.
bool is_visit(const http::Request& request) {
  return (request.method == "GET" || request.method == "HEAD") &&
         request.headers.find("Sec-Fetch-Mode") == "navigate" && request.headers.find("Sec-Fetch-Dest") == "document";
}

}  // namespace

BrowserGuard::BrowserGuard(std::vector<std::string> hosts, std::vector<std::string> origins)
    : hosts_(std::move(hosts)), origins_(std::move(origins)) {}

bool BrowserGuard::is_own(std::string_view name) const {
  if (holds(hosts_, name)) return true;
  if (is_ip_address(name) || name.find('.') == name.npos) return true;
  return ends_with_name(name, ".localhost") || http::same_name(name, "localhost.");
}

std::optional<Error> BrowserGuard::refuse(const http::Request& request) const {
  if (std::ranges::find(hosts_, "*") != hosts_.end()) return std::nullopt;
  // HTTP/1.0 has none; no browser speaks it.
  const std::string_view host = name_in(request.headers.find("Host").value_or("localhost"));
  if (!is_own(host)) {
    return http::wrong_value(ErrorCode::forbidden, "Host", host,
                             "localhost, an address, a name without a dot, or one of allowed-hosts");
  }
  const auto origin = request.headers.find("Origin");
  if (origin && holds(origins_, *origin)) return std::nullopt;
  if (origin && !http::same_name(host_of_origin(*origin), host)) {
    return http::wrong_value(ErrorCode::forbidden, "Origin", *origin, "the server's own pages, or one of cors-origins");
  }
  const auto site = request.headers.find("Sec-Fetch-Site");
  if (site == "cross-site" && !is_visit(request)) {
    return http::wrong_value(ErrorCode::forbidden, "Sec-Fetch-Site", *site,
                             "the server's own pages, or a visit to one of them");
  }
  return std::nullopt;
}

}  // namespace surfaced
