// SPDX-License-Identifier: GPL-3.0-or-later
#include <exception>
#include <span>

#include "command/command.hpp"
#include "command/health.hpp"
#include "command/problem.hpp"
#include "command/usage.hpp"
#include "reconstruction/reconstruction.hpp"

namespace {

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
  surfaced::add_json_flags(app);
  const std::span<char* const> words(argv + 1, argc > 0 ? static_cast<std::size_t>(argc - 1) : 0);
  if (surfaced::asks_for_json(words)) surfaced::set_problem_format(surfaced::ProblemFormat::json);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked_for_help) {
    return app.exit(asked_for_help);
  } catch (const CLI::ParseError& wrong) {
    return surfaced::report_usage(app, wrong, words);
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
