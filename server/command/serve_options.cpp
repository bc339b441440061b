// SPDX-License-Identifier: GPL-3.0-or-later
#include "command/serve_options.hpp"

#include <cstdlib>
#include <string>

namespace surfaced {
namespace {

std::optional<std::string> variable(const std::string& name) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): read before any thread is started, and nobody writes
  const char* const value = std::getenv(name.c_str());
  return value == nullptr ? std::nullopt : std::optional<std::string>(value);
}

}  // namespace

void add_setting_flags(CLI::App& command, Sources& sources) {
  const Settings defaults;
  command
      .add_option_function<std::string>(
          "--config", [&sources](const std::string& value) { sources.file = value; },
          "JSON file with settings by their names (SURFACED_CONFIG)")
      ->type_name("FILE");
  for (const Setting& setting : setting_table()) {
    const std::string standard = shown(setting, defaults);
    command
        .add_option_function<std::string>(
            "--" + std::string(setting.name),
            [&sources, &setting](const std::string& value) { sources.flags[std::string(setting.name)] = value; },
            std::string(setting.text) + " (" + environment_name(setting) + ")")
        ->type_name(allowed(setting) + (standard.empty() ? "" : ", default " + standard));
  }
}

void use_environment(Sources& sources) {
  sources.environment = variable;
  if (sources.file.empty()) sources.file = variable("SURFACED_CONFIG").value_or("");
}

}  // namespace surfaced
