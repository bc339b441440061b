// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/setting_table.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <vector>

namespace surfaced {
namespace {

constexpr std::uint64_t kSecondsADay = std::uint64_t{24} * 3600;
using S = Settings;

const auto kTable = std::to_array<Setting>({
    {"listen", SettingUnit::text, "", 0, 0, "Address to listen on, HOST:PORT; port 0 takes a free one", &S::listen},
    {"data", SettingUnit::path, "", 0, 0,
     "Folder of the job store and all files, on a local disk; one server at a time", &S::data},
    {"log-format", SettingUnit::text, "text|json", 0, 0, "Lines of the log on standard error", &S::log_format},
    {"log-level", SettingUnit::text, "debug|info|warning|error", 0, 0, "What is worth a line", &S::log_level},
    {"workers", SettingUnit::count, "", 0, 1024, "Jobs that run at once; 0: as many as cores", &S::workers},
    {"threads-per-job", SettingUnit::count, "", 0, 1024, "Threads a job may use; 0: all cores", &S::threads_per_job},
    {"job-time-limit", SettingUnit::seconds, "", 1, 30 * kSecondsADay, "Time a job may run", &S::job_time_limit},
    {"job-memory", SettingUnit::bytes, "", 0, kMostBytes,
     "Memory a job may use; 0: three quarters of the machine's over the workers", &S::job_memory},
    {"job-output", SettingUnit::bytes, "", 1 << 20, kMostBytes,
     "Size of any file that a job writes, and of all its files together", &S::job_output},
    {"max-points", SettingUnit::count, "", 1, 4'000'000'000, "Points a cloud may have", &S::max_points},
    {"queue-limit", SettingUnit::count, "", 1, 1'000'000, "Jobs that may wait; more are answered 503", &S::queue_limit},
    {"ttl", SettingUnit::seconds, "", 1, 365 * kSecondsADay, "Time that a job and its files are kept after its end",
     &S::ttl},
    {"gone-time", SettingUnit::seconds, "", 0, 365 * kSecondsADay, "Time that the id of a removed job answers 410",
     &S::gone_time},
    {"lease", SettingUnit::seconds, "", 3, 3600, "Silence after which a running job counts as lost", &S::lease},
    {"minimum-free", SettingUnit::bytes, "", 0, kMostBytes,
     "Space under the data folder that stays free; clouds that would use it are answered 507", &S::minimum_free},
    {"wait-limit", SettingUnit::seconds, "", 0, 600, "Time that /v1/reconstruct waits for the mesh", &S::wait_limit},
    {"body-limit", SettingUnit::bytes, "", 1, kMostBytes, "Size of a request's body; more is answered 413",
     &S::body_limit},
    {"body-grace", SettingUnit::seconds, "", 1, 3600, "Time that a body or an answer may take before its pace counts",
     &S::body_grace},
    {"body-rate", SettingUnit::bytes_per_second, "", 1, kMostBytes,
     "Pace that a client must keep up with after that; slower ones are answered 408 or cut off", &S::body_rate},
    {"header-limit", SettingUnit::bytes, "", 1024, 1 << 20,
     "Size of a request's line and headers; more is answered 431", &S::header_limit},
    {"header-time", SettingUnit::seconds, "", 1, 600, "Time in which the headers have to arrive, or 408",
     &S::header_time},
    {"idle-time", SettingUnit::seconds, "", 1, 3600, "Time that a connection may be silent between two requests",
     &S::idle_time},
    {"connections", SettingUnit::count, "", 2, 100'000,
     "Connections at once; beyond, the longest silent one is closed, or the new one answered 503", &S::connections},
    {"requests-per-connection", SettingUnit::count, "", 1, 1'000'000, "Requests after which a connection is closed",
     &S::requests_per_connection},
    {"http-threads", SettingUnit::count, "", 2, 1024,
     "Requests that are worked on at once; those that wait do not count", &S::http_threads},
    {"bodies", SettingUnit::count, "", 1, 1023,
     "Bodies that are received at once, fewer than http-threads; more are answered 503", &S::bodies},
    {"bodies-per-client", SettingUnit::count, "", 0, 1023,
     "Of these, from one address that is not loopback; more are answered 429; 0: no limit", &S::bodies_per_client},
    {"streams", SettingUnit::count, "", 1, 100'000,
     "Event streams at once, fewer than connections (3/4 of them if the default is not); more are answered 503",
     &S::streams},
    {"streams-per-client", SettingUnit::count, "", 0, 100'000,
     "Of these, for one key, or for one address that is not loopback; more are answered 429; 0: no limit",
     &S::streams_per_client},
    {"waits", SettingUnit::count, "", 0, 100'000,
     "Requests at once that wait for a job or a mesh, with the streams fewer than connections (1/5 of them if the "
     "default is not); more are answered 503, or 202 if they submit",
     &S::waits},
    {"waits-per-client", SettingUnit::count, "", 0, 100'000,
     "Of these, for one key, or for one address that is not loopback; more are answered 429; 0: no limit",
     &S::waits_per_client},
    {"drain-time", SettingUnit::seconds, "", 0, 3600, "Time that running jobs get when the server stops",
     &S::drain_time},
    {"drain-delay", SettingUnit::seconds, "", 0, 600,
     "Time between /readyz saying 503 and the end of listening, for load balancers", &S::drain_delay},
    {"tls-certificate", SettingUnit::path, "", 0, 0,
     "Certificate of the server and what leads to its root, PEM; none: plain HTTP. SIGHUP reads it again",
     &S::tls_certificate},
    {"tls-key", SettingUnit::path, "", 0, 0, "Key of the certificate, PEM without a pass phrase", &S::tls_key},
    {"keys", SettingUnit::path, "", 0, 0, "File of API keys, made by `surfaced keys`; none: nobody needs one",
     &S::keys},
    {"allow-anonymous", SettingUnit::text, "yes|no", 0, 0, "Listen on a public address although there are no keys",
     &S::allow_anonymous},
    {"rate-limit", SettingUnit::count, "", 0, 1'000'000,
     "Requests a minute of a client without a key, by address; 0: no limit, as on loopback", &S::rate_limit},
    {"submission-rate-limit", SettingUnit::count, "", 0, 1'000'000,
     "Of these, clouds, uploads and jobs that are sent; 0: no limit of their own", &S::submission_rate_limit},
    {"cors-origins", SettingUnit::text, "", 0, 0, "Origins whose pages may call, separated by commas, or *; none: none",
     &S::cors_origins},
    {"trusted-proxies", SettingUnit::text, "", 0, 0,
     "Addresses and networks (10.0.0.0/8) whose X-Forwarded-For is believed, separated by commas", &S::trusted_proxies},
    {"allowed-hosts", SettingUnit::text, "", 0, 0,
     "Without keys: names with a dot under which the server may be called, separated by commas; *: any, and pages of "
     "other sites too",
     &S::allowed_hosts},
    {"upload-time", SettingUnit::seconds, "", 1, 30 * kSecondsADay, "Time that an upload is kept without progress",
     &S::upload_time},
    {"uploads", SettingUnit::count, "", 1, 1'000'000, "Unfinished uploads at once; more are answered 503", &S::uploads},
    {"uploads-per-client", SettingUnit::count, "", 0, 1'000'000,
     "Of these, of one key, or of one address that is not loopback; more are answered 429; 0: no limit",
     &S::uploads_per_client},
    {"cloud-time", SettingUnit::seconds, "", 0, 3650 * kSecondsADay,
     "Time that a stored cloud is kept which nobody sends and no job uses; 0: until it is deleted", &S::cloud_time},
    {"webhook-secret", SettingUnit::path, "", 0, 0, "File of the key that signs webhooks; none: no webhooks",
     &S::webhook_secret},
    {"webhook-private", SettingUnit::text, "yes|no", 0, 0, "Send webhooks to private addresses too",
     &S::webhook_private},
    {"webhook-certificates", SettingUnit::path, "", 0, 0,
     "Certificates that webhooks are checked against; none: those of the system", &S::webhook_certificates},
});

std::vector<std::string> choices_of(const Setting& setting) {
  std::vector<std::string> words;
  for (std::string_view rest = setting.choices; !rest.empty();) {
    words.emplace_back(rest.substr(0, rest.find('|')));
    rest.remove_prefix(std::min(rest.size(), words.back().size() + 1));
  }
  return words;
}

Error wrong(const Setting& setting, std::string_view value) {
  return with_fault({ErrorCode::invalid_usage,
                     std::string(setting.name) + " is '" + std::string(value) + "'; allowed is " + allowed(setting)},
                    {std::string(setting.name), std::string(value), allowed(setting)});
}

}  // namespace

std::span<const Setting> setting_table() { return kTable; }

std::string environment_name(const Setting& setting) {
  std::string name = "SURFACED_";
  for (const char c : setting.name)
    name += c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

std::string shown(const Setting& setting, const Settings& settings) {
  if (const auto* text = std::get_if<std::string Settings::*>(&setting.place)) return settings.*(*text);
  if (const auto* path = std::get_if<std::filesystem::path Settings::*>(&setting.place)) {
    return (settings.*(*path)).string();
  }
  return with_unit(setting.unit, settings.*std::get<std::uint64_t Settings::*>(setting.place));
}

std::string allowed(const Setting& setting) {
  if (setting.unit == SettingUnit::text) return setting.choices.empty() ? "any text" : std::string(setting.choices);
  if (setting.unit == SettingUnit::path) return "a path";
  return with_unit(setting.unit, setting.least) + " to " + with_unit(setting.unit, setting.most);
}

Status assign(const Setting& setting, std::string_view value, Settings& settings) {
  if (const auto* path = std::get_if<std::filesystem::path Settings::*>(&setting.place)) {
    settings.*(*path) = std::filesystem::path(value);
    return Done{};
  }
  if (const auto* text = std::get_if<std::string Settings::*>(&setting.place)) {
    const std::vector<std::string> choices = choices_of(setting);
    if (!choices.empty() && std::ranges::find(choices, value) == choices.end()) return wrong(setting, value);
    settings.*(*text) = std::string(value);
    return Done{};
  }
  const auto number = number_in(setting.unit, value);
  if (!number || *number < setting.least || *number > setting.most) return wrong(setting, value);
  settings.*std::get<std::uint64_t Settings::*>(setting.place) = *number;
  return Done{};
}

}  // namespace surfaced
