// SPDX-License-Identifier: GPL-3.0-or-later
#include "command/command.hpp"
#include "worker/guard_main.hpp"
#include "worker/side_main.hpp"

namespace surfaced {
namespace {

void add_child(CLI::App& app, Run& run, const char* name, int (*main)(const std::string&)) {
  auto description = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(name, "A side task; the server starts this itself");
  command->group("");
  command->add_option("DESCRIPTION", *description)->required();
  command->callback([description, main, &run] { run = [description, main] { return main(*description); }; });
}

void add_guard(CLI::App& app, Run& run) {
  auto words = std::make_shared<std::pair<std::string, std::string>>();
  CLI::App* command = app.add_subcommand(kGuardCommand, "Watches a child for the server, which starts this itself");
  command->group("");
  command->add_option("COMMAND", words->first)->required();
  command->add_option("DESCRIPTION", words->second)->required();
  command->callback([words, &run] {
    run = [words] { return guard_main({"/proc/self/exe", words->first}, words->second); };
  });
}

}  // namespace

void add_side_tasks(CLI::App& app, Run& run) {
  add_guard(app, run);
  add_child(app, run, kInspectCommand, inspect_main);
  add_child(app, run, kConvertCommand, convert_main);
}

}  // namespace surfaced
