// SPDX-License-Identifier: GPL-3.0-or-later
// The real daemon, started for a test.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace surfaced::testing {

class ServerProcess {
 public:
  /// Starts `surfaced serve` on a free port and returns once it listens.
  /// @param log  file for its standard error; that of the test if empty
  ServerProcess(const std::filesystem::path& data, std::vector<std::string> flags = {},
                const std::filesystem::path& log = {}, const std::string& listen = "127.0.0.1:0") {
    std::filesystem::create_directories(data);
    const auto out = data.parent_path() / (data.filename().string() + ".stdout");
    std::filesystem::remove(out);
    std::vector<std::string> command = command_for(data, listen);
    command.insert(command.end(), flags.begin(), flags.end());
    start(command, out, log);
    for (int i = 0; i < 1200 && port_ == 0; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      read_port(out);
      int status = 0;
      if (::waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        throw std::runtime_error("the server ended at once with status " + std::to_string(status));
      }
    }
    if (port_ == 0) throw std::runtime_error("the server does not listen");
  }
  ~ServerProcess() {
    if (pid_ > 0) end(SIGKILL);
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  /// Starts a server and kills it after this time, whether it listens or not.
  static void kill_while_it_starts(const std::filesystem::path& data, std::chrono::milliseconds after) {
    ServerProcess server;
    server.start(command_for(data), "/dev/null", {});
    std::this_thread::sleep_for(after);
    server.end(SIGKILL);
  }

  std::uint16_t port() const { return port_; }
  pid_t pid() const { return pid_; }

  /// Sends the signal and waits; the exit code, or minus the signal.
  int end(int signal) {
    ::kill(pid_, signal);
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
  }

  /// Children of the server that are alive, leaders of process groups: the work may be done by a child of theirs.
  std::vector<pid_t> children() const {
    std::vector<pid_t> found;
    for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(pid_) + "/task")) {
      std::ifstream list(task.path() / "children");
      for (pid_t each = 0; list >> each;) found.push_back(each);
    }
    return found;
  }

 private:
  ServerProcess() = default;

  static std::vector<std::string> command_for(const std::filesystem::path& data,
                                              const std::string& listen = "127.0.0.1:0") {
    return {SURFACED_BINARY, "serve", "--listen", listen, "--data", data.string()};
  }

  void start(const std::vector<std::string>& command, const std::filesystem::path& out,
             const std::filesystem::path& log) {
    std::vector<char*> arguments;
    arguments.reserve(command.size() + 1);
    for (const auto& each : command) arguments.push_back(const_cast<char*>(each.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (!log.empty()) {
      posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    }
    const int failed = ::posix_spawn(&pid_, arguments.front(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) throw std::runtime_error("cannot start " + command.front());
  }

  void read_port(const std::filesystem::path& out) {
    std::ifstream file(out);
    std::string line;
    if (!std::getline(file, line) || file.eof()) return;
    port_ = static_cast<std::uint16_t>(std::stoul(line.substr(line.rfind(':') + 1)));
  }

  pid_t pid_ = -1;
  std::uint16_t port_ = 0;
};

}  // namespace surfaced::testing
