// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "access/browser_guard.hpp"
#include "access/keys.hpp"
#include "access/pace.hpp"
#include "http/router.hpp"
#include "jobs/job_store.hpp"
#include "platform/network.hpp"

namespace surfaced {

/// Who may come in, and how often.
struct AccessRules {
  /// Empty: nobody needs a key, and everybody sees everything.
  std::filesystem::path keys;
  /// Requests a minute of a client without a key, by address; 0 for no limit. Loopback has none.
  std::uint64_t requests_per_minute = 0;
  /// Of these, clouds, uploads and jobs that are sent; 0 for no limit of their own.
  std::uint64_t submissions_per_minute = 0;
  /// Those whose X-Forwarded-For is believed.
  std::vector<Network> trusted_proxies;
  /// Origins whose pages may call; `*` for all. Empty: none.
  std::vector<std::string> cors_origins;
  /// Of a server that only this machine can reach and that asks for no key; none for any other.
  std::optional<BrowserGuard> browsers;
};

/// Stands before every handler, behind the routing: finds the caller by his key, counts his requests, holds him to his
/// scopes, his quota and his own jobs, and speaks CORS. Handlers need not think of any of it.
class AccessFilter final : public http::RequestFilter {
 public:
  AccessFilter(AccessRules rules, JobStore& jobs) : rules_(std::move(rules)), jobs_(jobs) {}

  /// Reads the keys for the first time; invalid_usage.
  Status open();

  std::optional<http::Response> preflight(const http::Request& request) const override;
  std::optional<http::Response> refuse(http::Request& request, std::string_view route) override;
  void decorate(const http::Request& request, http::Response& response) const override;

 private:
  /// The keys as they are in the file; looked at again when it has changed.
  std::shared_ptr<const KeyRing> ring();
  std::optional<http::Response> check_key(http::Request& request, std::string_view route);
  /// Counts the request, and once more if it sends something.
  std::optional<http::Response> check_pace(const http::Request& request, std::string_view route,
                                           const std::string& client, std::uint64_t requests,
                                           std::uint64_t submissions);
  std::optional<http::Response> count(const http::Request& request, const std::string& client, const char* what,
                                      std::uint64_t per_minute);
  std::optional<Error> check_scope(const http::Request& request, const Key& key, std::string_view route) const;
  /// A first look, before a byte of the body is read. What counts is decided when the job, cloud or upload is stored.
  std::optional<Error> check_quota(const http::Request& request, const Key& key, std::string_view route);
  std::optional<Error> check_owner(const http::Request& request, std::string_view route);
  bool is_allowed(std::string_view origin) const;

  const AccessRules rules_;
  JobStore& jobs_;
  Pace pace_;
  std::mutex mutex_;
  std::shared_ptr<const KeyRing> ring_;
  std::chrono::steady_clock::time_point looked_;
  std::filesystem::file_time_type changed_;
};

}  // namespace surfaced
