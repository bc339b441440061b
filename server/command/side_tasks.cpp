// SPDX-License-Identifier: GPL-3.0-or-later
#include "command/command.hpp"
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

}  // namespace

void add_side_tasks(CLI::App& app, Run& run) {
  add_child(app, run, kInspectCommand, inspect_main);
  add_child(app, run, kConvertCommand, convert_main);
}

}  // namespace surfaced
