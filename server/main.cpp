// SPDX-License-Identifier: GPL-3.0-or-later
#include <exception>
#include <iostream>

#include "command/command.hpp"
#include "command/health.hpp"
#include "command/problem.hpp"
#include "reconstruction/reconstruction.hpp"

namespace {

/// What was wrong with the command line: above all, that its first word is no command.
std::string what_is_wrong(const CLI::App& app, const CLI::ParseError& wrong, int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  std::string known;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->check_name(first)) return wrong.what();
    if (!command->get_group().empty()) known += (known.empty() ? "" : ", ") + command->get_name();
  }
  const bool is_flag = first.starts_with('-');
  if (is_flag) return wrong.what();
  return (first.empty() ? "no command is given" : "'" + first + "' is no command") + "; there are: " + known;
}

int dispatch(int argc, char** argv) {
  CLI::App app("Point clouds to meshes: a daemon, a library and a command.", "surfaced");
  app.set_version_flag("--version", std::string(surfaced::version()));
  app.require_subcommand(1);
  surfaced::Run run;
  surfaced::add_reconstruct(app, run);
  surfaced::add_measure(app, run);
  surfaced::add_methods(app, run);
  surfaced::add_serve(app, run);
  surfaced::add_check_config(app, run);
  surfaced::add_health(app, run);
  surfaced::add_keys(app, run);
  surfaced::add_backup(app, run);
  surfaced::add_attempt(app, run);
  surfaced::add_side_tasks(app, run);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked_for_help) {
    return app.exit(asked_for_help);
  } catch (const CLI::ParseError& wrong) {
    return surfaced::report_problem({surfaced::ErrorCode::invalid_usage, what_is_wrong(app, wrong, argc, argv)});
  }
  return run();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return dispatch(argc, argv);
  } catch (const std::bad_alloc&) {
    return surfaced::report_problem({surfaced::ErrorCode::out_of_memory, "an allocation failed"});
  } catch (const std::exception& failure) {
    return surfaced::report_problem({surfaced::ErrorCode::internal_error, failure.what()});
  }
}
