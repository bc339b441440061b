// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/configuration.hpp"

#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/text.hpp"
#include "platform/machine.hpp"
#include "platform/network.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::json;

/// Descriptors beside those of connections: the store, files that are sent and received, pipes of children.
constexpr std::uint64_t kOtherFiles = 64;
constexpr std::uint64_t kFilesPerThread = 2;
constexpr std::uint64_t kFilesPerWorker = 8;
constexpr std::uint64_t kFewestConnections = 64;

std::optional<std::string> read_text(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::shared_ptr<const Fault> unknown_setting(const std::string& name) {
  return std::make_shared<const Fault>(
      Fault{name, std::nullopt, "one of " + joined(setting_table(), ", ", &Setting::name)});
}

/// The file's values as text, by name.
std::map<std::string, std::string, std::less<>> read_file(const std::filesystem::path& path,
                                                          Configuration& configuration) {
  std::map<std::string, std::string, std::less<>> values;
  if (path.empty()) return values;
  const auto text = read_text(path);
  if (!text) {
    configuration.refuse("the file '" + path.string() + "' cannot be read");
    return values;
  }
  const Json json = Json::parse(*text, nullptr, false, true);
  if (!json.is_object()) {
    configuration.refuse("the file '" + path.string() + "' is no JSON object");
    return values;
  }
  for (const auto& [name, value] : json.items()) {
    if (std::ranges::find(setting_table(), name, &Setting::name) == setting_table().end()) {
      configuration.refuse("the file '" + path.string() + "' sets '" + name + "', which is no setting",
                           unknown_setting(name));
    } else if (value.is_string()) {
      values[name] = value.get<std::string>();
    } else if (value.is_number_unsigned()) {
      values[name] = value.dump();
    } else {
      configuration.refuse(name + " is " + value.dump() + " in the file; a text or a whole number is expected");
    }
  }
  return values;
}

struct Given {
  std::string value;
  std::string source;
};

std::optional<Given> from_environment(const Setting& setting, const Sources& sources, Configuration& configuration) {
  if (!sources.environment) return std::nullopt;
  const std::string name = environment_name(setting);
  const auto direct = sources.environment(name);
  const auto path = sources.environment(name + "_FILE");
  if (direct && path) configuration.refuse(name + " and " + name + "_FILE are both set");
  if (direct) return Given{*direct, name};
  if (!path) return std::nullopt;
  auto text = read_text(*path);
  if (!text) {
    configuration.refuse(name + "_FILE names '" + *path + "', which cannot be read");
    return std::nullopt;
  }
  while (!text->empty() && (text->back() == '\n' || text->back() == '\r')) text->pop_back();
  return Given{*text, name + "_FILE"};
}

bool is_default(const Configuration& configuration, std::string_view name) {
  return std::ranges::find(configuration.entries, name, [](const auto& each) { return each.setting->name; })->source ==
         "default";
}

void refuse_number(Configuration& configuration, const char* name, std::uint64_t value, const std::string& allowed) {
  const std::string number = std::to_string(value);
  configuration.refuse(std::string(name) + " is " + number + "; allowed is " + allowed,
                       std::make_shared<const Fault>(Fault{name, number, allowed}));
}

/// A stream and a wait hold a connection: some are to stay for other requests.
void check_streams(Configuration& configuration) {
  Settings& settings = configuration.settings;
  if (settings.streams >= settings.connections && is_default(configuration, "streams")) {
    settings.streams = std::max<std::uint64_t>(1, settings.connections / 4 * 3);
  }
  if (settings.streams >= settings.connections) {
    refuse_number(configuration, "streams", settings.streams,
                  "less than connections, which is " + std::to_string(settings.connections));
    return;
  }
  const std::uint64_t left = settings.connections - settings.streams;
  if (settings.waits < left) return;
  if (is_default(configuration, "waits")) {
    settings.waits = std::min(settings.connections / 5, left - 1);
    return;
  }
  refuse_number(configuration, "waits", settings.waits,
                "less than the connections without the streams, which are " + std::to_string(left));
}

/// An entry that is no address would be trusted by nobody, in silence.
void check_proxies(Configuration& configuration) {
  const auto networks = networks_in(configuration.settings.trusted_proxies);
  if (!networks) configuration.refuse("trusted-proxies has " + networks.error().detail);
}

void check_together(Configuration& configuration) {
  const Settings& settings = configuration.settings;
  if (settings.data.empty())
    configuration.refuse("data is not set: name a folder for jobs and clouds with --data or SURFACED_DATA",
                         std::make_shared<const Fault>(
                             Fault{"data", std::nullopt, "a folder on a local disk, like --data ./surfaced-data"}));
  if (settings.tls_certificate.empty() != settings.tls_key.empty()) {
    configuration.refuse(settings.tls_key.empty() ? "tls-certificate is set and tls-key is not"
                                                  : "tls-key is set and tls-certificate is not");
  }
  if (settings.bodies >= settings.http_threads) {
    refuse_number(configuration, "bodies", settings.bodies,
                  "less than http-threads, which is " + std::to_string(settings.http_threads));
  }
  check_streams(configuration);
  check_proxies(configuration);
}

std::string text_of_bytes(std::uint64_t bytes) { return std::to_string(bytes >> 20) + " MiB"; }

void check_data(Configuration& configuration) {
  const std::filesystem::path& data = configuration.settings.data;
  if (data.empty()) return;
  std::error_code error;
  std::filesystem::path existing = std::filesystem::absolute(data, error);
  while (!existing.empty() && !std::filesystem::exists(existing, error) && existing.has_relative_path()) {
    existing = existing.parent_path();
  }
  if (!std::filesystem::is_directory(existing, error) || ::access(existing.c_str(), W_OK | X_OK) != 0) {
    configuration.refuse("data is '" + data.string() + "'; '" + existing.string() +
                         "' is no folder that this user can write: give another (--data, SURFACED_DATA), " +
                         "or make '" + data.string() + "' a folder of user " + std::to_string(::geteuid()));
    return;
  }
  struct statvfs disk {};
  if (::statvfs(existing.c_str(), &disk) != 0) return;
  const std::uint64_t free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  if (free < configuration.settings.minimum_free) {
    configuration.warnings.push_back(text_of_bytes(free) + " are free under data, minimum-free is " +
                                     text_of_bytes(configuration.settings.minimum_free) +
                                     ": clouds will be answered 507");
  }
}

/// Connections that were asked for must be possible; the default makes do with what there is.
void check_files(Configuration& configuration, const Settings& settings) {
  rlimit files{};
  ::getrlimit(RLIMIT_NOFILE, &files);
  const std::uint64_t others =
      kFilesPerThread * settings.http_threads + kFilesPerWorker * settings.workers + kOtherFiles;
  if (files.rlim_max >= settings.connections + others) return;
  const std::string what = "connections is " + std::to_string(settings.connections) + ", which needs " +
                           std::to_string(settings.connections + others) + " open files; the limit (ulimit -Hn) is " +
                           std::to_string(files.rlim_max);
  if (!is_default(configuration, "connections") || files.rlim_max < others + kFewestConnections) {
    configuration.refuse(what);
    return;
  }
  configuration.settings.connections = files.rlim_max - others;
  configuration.warnings.push_back(what + ": " + std::to_string(configuration.settings.connections) + " are taken");
  check_streams(configuration);
}

}  // namespace

Configuration read_configuration(const Sources& sources) {
  Configuration configuration;
  const auto file = read_file(sources.file, configuration);
  for (const Setting& setting : setting_table()) {
    std::optional<Given> given = from_environment(setting, sources, configuration);
    if (const auto flag = sources.flags.find(setting.name); flag != sources.flags.end()) {
      given = Given{flag->second, "--" + flag->first};
    } else if (const auto line = file.find(setting.name); !given && line != file.end()) {
      given = Given{line->second, "file"};
    }
    configuration.entries.push_back({&setting, given ? given->source : "default"});
    if (!given) continue;
    if (const Status assigned = assign(setting, given->value, configuration.settings); !assigned) {
      configuration.refuse(assigned.error().detail + " (from " + given->source + ")", assigned.error().fault);
    }
  }
  check_together(configuration);
  return configuration;
}

std::string details_of(std::span<const Error> problems) { return joined(problems, "; ", &Error::detail); }

void check_machine(Configuration& configuration) {
  Settings settings = configuration.settings;
  settings.resolve();
  check_data(configuration);
  check_files(configuration, settings);
  const std::uint64_t memory = machine_memory();
  if (settings.job_memory > memory / settings.workers) {
    configuration.warnings.push_back(std::to_string(settings.workers) + " workers with a job-memory of " +
                                     text_of_bytes(settings.job_memory) + " may use more than the machine's " +
                                     text_of_bytes(memory));
  }
}

}  // namespace surfaced
