// Takes the place of `surfaced attempt` in tests and behaves as the job's parameter "behave" says.
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <new>
#include <vector>

#include "platform/files.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/confinement.hpp"

namespace {

using namespace surfaced;

void send(std::string_view message) {
  if (!write_all(kMessageDescriptor, as_bytes(message), "tell the server")) ::_exit(9);
}

int refuse(ErrorCode code) {
  send(encode(Error{code, "as the test asked"}));
  return exit_code_of(code);
}

int succeed(const AttemptSpec& spec) {
  send(encode(ProgressMessage{0.5, "half"}));
  std::ofstream(spec.directory / spec.mesh) << "mesh of " << spec.claim.job;
  std::ofstream(spec.directory / "report.json") << "{}";
  return 0;
}

[[noreturn]] void sleep_for_ever() {
  for (;;) ::pause();
}

int allocate() {
  try {
    std::vector<std::unique_ptr<std::vector<char>>> blocks;
    for (;;) blocks.push_back(std::make_unique<std::vector<char>>(std::size_t{16} << 20, 'x'));
  } catch (const std::bad_alloc&) {
    return refuse(ErrorCode::out_of_memory);
  }
}

int litter(const AttemptSpec& spec) {
  std::filesystem::create_symlink("/etc/passwd", spec.directory / spec.mesh);
  std::ofstream(spec.directory / "report.json") << "{}";
  return 0;
}

int shout(const AttemptSpec& spec) {
  const std::string line(std::size_t{1} << 16, 'x');
  for (int i = 0; i < 64; ++i) std::cerr << line << "\n";
  send(line);
  send("\n{\"progress\":7}\n{\"code\":\"no such code\"}\nnull\n[1\n");
  return succeed(spec);
}

int leave_a_grandchild(const AttemptSpec& spec) {
  if (::fork() == 0) sleep_for_ever();
  return succeed(spec);
}

int behave(const std::string& how, const AttemptSpec& spec) {
  if (how == "done") return succeed(spec);
  if (how == "crash" || (how == "crash once" && spec.claim.attempt == 1)) std::raise(SIGSEGV);
  if (how == "crash once") return succeed(spec);
  if (how == "exit 7") return 7;
  if (how == "nothing") return 0;
  if (how == "refuse") return refuse(ErrorCode::collinear);
  if (how == "allocate") return allocate();
  if (how == "litter") return litter(spec);
  if (how == "shout") return shout(spec);
  if (how == "fork") return leave_a_grandchild(spec);
  if (how == "spin") {
    for (volatile bool go = true; go;) {
    }
  }
  if (how == "hang deaf") std::signal(SIGTERM, SIG_IGN);
  send(encode(ProgressMessage{0.25, "hanging"}));
  sleep_for_ever();
}

}  // namespace

int main(int /*argc*/, char** argv) {
  const auto spec = decode_attempt(argv[1]);
  if (!spec || !confine_this_process(spec->limits, spec->parent)) return 8;
  return behave(spec->parameters.value("behave", "done"), *spec);
}
