// SPDX-License-Identifier: GPL-3.0-or-later
// Takes the place of `surfaced attempt` in tests and behaves as the job's parameter "behave" says.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "hostile_calls.hpp"
#include "platform/files.hpp"
#include "worker/attempt_budget.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/confinement.hpp"
#include "worker/guard_main.hpp"

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

/// What only a child without its confinement could do: the server must stand it all the same.
void break_out(const std::string& how, const AttemptSpec& spec) {
  if (how == "litter") {
    std::filesystem::create_symlink("/etc/passwd", spec.directory / spec.mesh);
    std::ofstream(spec.directory / "report.json") << "{}";
  }
  if (how == "leave a grandchild" && ::fork() == 0) sleep_for_ever();
  if (how == "kill the watcher") ::kill(spec.parent, SIGKILL);
}

int shout(const AttemptSpec& spec) {
  const std::string line(std::size_t{1} << 16, 'x');
  for (int i = 0; i < 64; ++i) std::cerr << line << "\n";
  send(line);
  send("\n{\"progress\":7}\n{\"code\":\"no such code\"}\nnull\n[1\n");
  return succeed(spec);
}

/// Memory that RLIMIT_DATA does not count.
int share_without_end() {
  constexpr std::size_t kBlock = std::size_t{16} << 20;
  for (;;) {
    void* const block = ::mmap(nullptr, kBlock, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (block == MAP_FAILED) return 7;
    std::memset(block, 'x', kBlock);
  }
}

int write_without_end(const AttemptSpec& spec) {
  std::ofstream file(spec.directory / spec.mesh);
  const std::string block(std::size_t{1} << 20, 'x');
  while (file << block) {
  }
  return 7;
}

int make_files_without_end(const AttemptSpec& spec) {
  for (int i = 0;; ++i) std::ofstream(spec.directory / ("file" + std::to_string(i))) << i;
}

/// Each is small enough, both are not.
int make_two_large_files(const AttemptSpec& spec) {
  const std::string block(std::size_t{12} << 20, 'x');
  for (const char* name : {"one", "two"}) std::ofstream(spec.directory / name) << block;
  sleep_for_ever();
}

/// Each takes its place on the disk although nobody can see it.
int hide_files_without_end(const AttemptSpec& spec) {
  const std::string block(std::size_t{1} << 20, 'x');
  std::vector<int> kept;
  for (;;) {
    const std::string name = spec.directory / "hidden";
    const int file = ::open(name.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    if (!write_all(file, as_bytes(block), "hide")) return 7;
    std::filesystem::remove(name);
    if (kept.size() < 40) {
      kept.push_back(file);
    } else {
      ::close(file);
    }
  }
}

int start_threads_without_end() {
  pthread_attr_t small;
  pthread_attr_init(&small);
  pthread_attr_setstacksize(&small, std::size_t{1} << 20);
  const auto idle = [](void*) -> void* { sleep_for_ever(); };
  pthread_t thread{};
  int count = 0;
  while (pthread_create(&thread, &small, idle, nullptr) == 0) ++count;
  send(encode(Error{ErrorCode::method_failed, std::to_string(count)}));
  return exit_code_of(ErrorCode::method_failed);
}

/// Tells the limits that the kernel holds it to.
int tell_limits() {
  const std::initializer_list<std::pair<const char*, __rlimit_resource_t>> kinds{
      {"DATA", RLIMIT_DATA}, {"FSIZE", RLIMIT_FSIZE}, {"NOFILE", RLIMIT_NOFILE},
      {"CORE", RLIMIT_CORE}, {"CPU", RLIMIT_CPU},     {"NPROC", RLIMIT_NPROC}};
  std::string told;
  for (const auto& [name, kind] : kinds) {
    rlimit limit{};
    if (::getrlimit(kind, &limit) == 0)
      told.append(name).append(" ").append(std::to_string(limit.rlim_cur)).append(" ");
  }
  send(encode(Error{ErrorCode::method_failed, told}));
  return exit_code_of(ErrorCode::method_failed);
}

int speak_without_end() {
  const std::string line(std::size_t{1} << 16, 'x');
  for (;;) std::cerr << line;
}

/// Ends well if everything is refused, with what was not otherwise.
int reach_out(const AttemptSpec& spec) {
  const std::string taken = testing::reach_out(spec);
  if (taken.empty()) return succeed(spec);
  send(encode(Error{ErrorCode::method_failed, taken}));
  return exit_code_of(ErrorCode::method_failed);
}

int hostile(const std::string& how, const AttemptSpec& spec) {
  if (how == "files") return make_files_without_end(spec);
  if (how == "bytes") return make_two_large_files(spec);
  if (how == "hidden files") return hide_files_without_end(spec);
  if (how == "threads") return start_threads_without_end();
  if (how == "limits") return tell_limits();
  if (how == "words") return speak_without_end();
  if (how == "reach out") return reach_out(spec);
  if (how == "look around") return testing::sees_other_files() ? 7 : succeed(spec);
  if (how.starts_with("call ")) testing::call_by_name(how.substr(5));
  if (how == "x32") ::syscall(0x40000000L + 39);
  if (how.starts_with("seed ")) testing::call_anything(spec, std::stoull(how.substr(5)));
  return 6;
}

/// Ends well if the confinement forbids it, with what came back otherwise.
int forbidden(const std::string& what, const AttemptSpec& spec) {
  const auto refused = [&](long result) { return result < 0 ? succeed(spec) : 7; };
  if (what == "fork") return refused(::fork());
  if (what == "kill the parent") return refused(::kill(spec.parent, 0));
  if (what == "read a file") return refused(::open("/etc/passwd", O_RDONLY | O_CLOEXEC));
  if (what == "write a file") {
    return refused(::open((spec.directory.parent_path() / "x").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  }
  if (what == "a socket") return refused(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (what == "exec") return refused(::execl("/bin/true", "true", nullptr));
  if (what == "ptrace") return refused(::ptrace(PTRACE_ATTACH, spec.parent, nullptr, nullptr));
  return 6;
}

/// What a real attempt does with its confinement on: threads, files in its directory, the time.
int work_in_threads(const AttemptSpec& spec) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&spec, i] { std::ofstream(spec.directory / ("part" + std::to_string(i))) << "x"; });
  }
  for (std::thread& each : threads) each.join();
  for (int i = 0; i < 4; ++i) std::filesystem::remove(spec.directory / ("part" + std::to_string(i)));
  return succeed(spec);
}

/// Works on when what a small cloud may take is used up.
int exceed(const std::string& what, const AttemptSpec& spec) {
  AttemptBudget budget(spec.limits);
  constexpr std::uint64_t kBytes = std::uint64_t{96} << 20;
  const Cost cost = what == "time" ? Cost{0.2, spec.limits.memory_bytes} : Cost{1e6, kBytes};
  if (!budget.begin("3 points with method", cost)) return 7;
  if (what == "memory") return allocate();
  for (volatile bool go = true; go;) {
  }
  return 7;
}

int behave(const std::string& how, const AttemptSpec& spec) {
  if (how == "done") return succeed(spec);
  if (how == "crash" || (how == "crash once" && spec.claim.attempt == 1)) std::raise(SIGSEGV);
  if (how == "crash once") return succeed(spec);
  if (how == "exit 7") return 7;
  if (how == "nothing") return 0;
  if (how == "refuse") return refuse(ErrorCode::collinear);
  if (how == "allocate") return allocate();
  if (how.starts_with("exceed ")) return exceed(how.substr(7), spec);
  if (how == "share") return share_without_end();
  if (how == "write") return write_without_end(spec);
  if (how == "threads") return work_in_threads(spec);
  if (how == "shout") return shout(spec);
  if (how == "litter") return 0;
  if (how == "leave a grandchild") return succeed(spec);
  if (how.starts_with("hostile ")) return hostile(how.substr(8), spec);
  if (how.starts_with("try ")) return forbidden(how.substr(4), spec);
  if (how == "spin") {
    for (volatile bool go = true; go;) {
    }
  }
  if (how == "hang deaf") std::signal(SIGTERM, SIG_IGN);
  send(encode(ProgressMessage{0.25, "hanging"}));
  sleep_for_ever();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[1]) == kGuardCommand) {
    // In a PID namespace nobody could do to it what the tests want done.
    return guard_main({argv[0]}, argv[2], ChildProcess::Namespaces::shared);
  }
  const auto spec = decode_attempt(argv[1]);
  if (!spec) return 8;
  const std::string how = spec->parameters.value("behave", "done");
  break_out(how, *spec);
  const auto confined = confine_this_process(*spec);
  if (!confined) return 8;
  std::cerr << *confined << std::endl;
  return behave(how, *spec);
}
