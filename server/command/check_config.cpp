// SPDX-License-Identifier: GPL-3.0-or-later
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "command/command.hpp"
#include "command/problem.hpp"
#include "command/serve_options.hpp"
#include "http/tls.hpp"

namespace surfaced {
namespace {

using Json = nlohmann::ordered_json;

struct CheckOptions {
  Sources sources;
  std::string file;
  bool as_json = false;
};

void print_as_json(const Configuration& configuration) {
  Json settings = Json::array();
  for (const Configuration::Entry& entry : configuration.entries) {
    settings.push_back({{"name", entry.setting->name},
                        {"value", shown(*entry.setting, configuration.settings)},
                        {"source", entry.source},
                        {"allowed", allowed(*entry.setting)},
                        {"description", entry.setting->text}});
  }
  Json problems = Json::array();
  for (const Error& problem : configuration.problems) problems.push_back(problem.detail);
  const Json all{{"settings", settings}, {"warnings", configuration.warnings}, {"problems", problems}};
  std::cout << all.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
}

void print_as_text(const Configuration& configuration) {
  for (const Configuration::Entry& entry : configuration.entries) {
    std::cout << entry.setting->name << " = " << shown(*entry.setting, configuration.settings) << "  [" << entry.source
              << "]  " << allowed(*entry.setting) << "\n";
  }
  for (const std::string& warning : configuration.warnings) std::cout << "warning: " << warning << "\n";
}

void check_tls(Configuration& configuration) {
  const Settings& settings = configuration.settings;
  if (settings.tls_certificate.empty() || settings.tls_key.empty()) return;
  const auto tls = http::Tls::load({settings.tls_certificate, settings.tls_key});
  if (!tls) configuration.refuse(tls.error().detail, tls.error().fault);
}

int check(CheckOptions& options) {
  if (!options.file.empty()) options.sources.file = options.file;
  use_environment(options.sources);
  Configuration configuration = read_configuration(options.sources);
  check_machine(configuration);
  check_tls(configuration);
  options.as_json ? print_as_json(configuration) : print_as_text(configuration);
  if (configuration.problems.empty()) return 0;
  return report_problems(configuration.problems);
}

}  // namespace

void add_check_config(CLI::App& app, Run& run) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command =
      app.add_subcommand("check-config", "Show every setting of the service, where it comes from, and what is wrong");
  command->add_option("FILE", options->file, "File with settings, as for serve --config");
  command->add_flag("--json", options->as_json, "As JSON, errors too")->envname("SURFACED_JSON");
  add_setting_flags(*command, options->sources);
  command->callback([options, &run] { run = [options] { return check(*options); }; });
}

}  // namespace surfaced
