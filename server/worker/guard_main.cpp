// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/guard_main.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <iostream>

#include "worker/attempt_runner.hpp"
#include "worker/confined_work.hpp"

namespace surfaced {
namespace {

StopSignal& stop_signal() {
  static StopSignal stop;
  return stop;
}

/// The server asks to end by SIGTERM; the watch below then ends the child, as gently as the server would.
void listen_to_the_server() {
  stop_signal();
  struct sigaction action {};
  action.sa_handler = [](int) { stop_signal().stop(Outcome::cancelled); };
  ::sigaction(SIGTERM, &action, nullptr);
}

/// The code by which the server knows the outcome again.
Error as_told(const AttemptResult& result) {
  Error error = result.error.value_or(Error{ErrorCode::crashed, "the process ended without a reason"});
  if (result.outcome == Outcome::lost && error.code != ErrorCode::storage_full) error.code = ErrorCode::lost;
  return error;
}

}  // namespace

int guard_main(std::vector<std::string> command, const std::string& description, ChildProcess::Namespaces namespaces) {
  auto spec = decode_attempt(description);
  if (!spec) {
    std::cerr << spec.error().detail << "\n";
    return exit_code_of(spec.error().code);
  }
  listen_to_the_server();
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0 || ::getppid() != spec->parent) return exit_code_of(ErrorCode::lost);
  spec->parent = ::getpid();
  AttemptLog log = AttemptLog::onto(UniqueFd(::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0)));
  const AttemptRunner runner(std::move(command), namespaces);
  const AttemptResult result = runner.run(*spec, stop_signal(), log, [](double progress, std::string_view phase) {
    tell_server(encode(ProgressMessage{progress, std::string(phase)}));
  });
  log.close();
  if (result.outcome == Outcome::done) return 0;
  const Error error = as_told(result);
  tell_server(encode(error));
  return exit_code_of(error.code);
}

}  // namespace surfaced
