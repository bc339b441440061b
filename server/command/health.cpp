// SPDX-License-Identifier: GPL-3.0-or-later
#include <curl/curl.h>

#include <iostream>
#include <memory>

#include "command/health.hpp"
#include "command/problem.hpp"
#include "command/serve_options.hpp"
#include "http/server.hpp"

namespace surfaced {
namespace {

constexpr long kMilliseconds = 3'000;
constexpr std::size_t kLongestAnswer = std::size_t{64} << 10;

struct FreeHandle {
  void operator()(CURL* handle) const { ::curl_easy_cleanup(handle); }
};

std::size_t keep(char* bytes, std::size_t size, std::size_t count, void* text) {
  auto& kept = *static_cast<std::string*>(text);
  if (kept.size() + size * count > kLongestAnswer) return 0;
  kept.append(bytes, size * count);
  return size * count;
}

/// Where this machine reaches a server that listens there.
std::string url_of(const http::Address& address, bool tls) {
  const std::string host = address.host == "0.0.0.0" ? "127.0.0.1" : address.host == "::" ? "::1" : address.host;
  const std::string written = host.find(':') == host.npos ? host : "[" + host + "]";
  return (tls ? "https://" : "http://") + written + ":" + std::to_string(address.port) + "/readyz";
}

Status ask(const std::string& url) {
  const std::unique_ptr<CURL, FreeHandle> handle(::curl_easy_init());
  if (!handle) return Error{ErrorCode::out_of_memory, "libcurl cannot be set up"};
  std::string answer;
  ::curl_easy_setopt(handle.get(), CURLOPT_URL, url.c_str());
  ::curl_easy_setopt(handle.get(), CURLOPT_PROXY, "");  // of the environment, none
  ::curl_easy_setopt(handle.get(), CURLOPT_TIMEOUT_MS, kMilliseconds);
  // The certificate is for the server's public name, and this asks by the address of the same machine.
  ::curl_easy_setopt(handle.get(), CURLOPT_SSL_VERIFYPEER, 0L);
  ::curl_easy_setopt(handle.get(), CURLOPT_SSL_VERIFYHOST, 0L);
  ::curl_easy_setopt(handle.get(), CURLOPT_NOSIGNAL, 1L);
  ::curl_easy_setopt(handle.get(), CURLOPT_WRITEFUNCTION, keep);
  ::curl_easy_setopt(handle.get(), CURLOPT_WRITEDATA, &answer);
  if (const CURLcode failed = ::curl_easy_perform(handle.get()); failed != CURLE_OK) {
    return Error{ErrorCode::not_ready, "no answer from " + url + ": " + ::curl_easy_strerror(failed)};
  }
  long status = 0;
  ::curl_easy_getinfo(handle.get(), CURLINFO_RESPONSE_CODE, &status);
  if (status != 200) {
    return Error{ErrorCode::not_ready, url + " answers " + std::to_string(status) + ": " + answer};
  }
  return Done{};
}

int check_health(Sources& sources) {
  use_environment(sources);
  // The server itself has checked its settings; here only its address counts.
  const Settings settings = read_configuration(sources).settings;
  const auto address = http::parse_address(settings.listen);
  if (!address) return report_problem(address.error());
  const std::string url = url_of(*address, !settings.tls_certificate.empty());
  if (const Status ready = ask(url); !ready.ok()) return report_problem(ready.error());
  std::cout << url << " is ready\n";
  return 0;
}

}  // namespace

void add_health(CLI::App& app, Run& run) {
  auto sources = std::make_shared<Sources>();
  CLI::App* command = app.add_subcommand("health", "Ask the server on this machine whether it is ready");
  add_setting_flags(*command, *sources);
  command->callback([sources, &run] { run = [sources] { return check_health(*sources); }; });
}

}  // namespace surfaced
