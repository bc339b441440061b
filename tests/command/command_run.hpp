// SPDX-License-Identifier: GPL-3.0-or-later
// The command, run as a user runs it.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "io/io.hpp"
#include "support/limited_child.hpp"
#include "support/shapes.hpp"

namespace surfaced::testing {

struct Ran {
  int exit_code = -1;
  std::string out;
  std::string err;
  /// Of the processor.
  double seconds = 0;
  double peak_megabytes = 0;
};

inline std::string read_all(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class Command : public ::testing::Test {
 protected:
  Command() : folder_(std::filesystem::temp_directory_path() / ("surfaced-command-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~Command() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  std::filesystem::path sphere(std::size_t points = 500) const {
    const auto bytes = encode_cloud_ply(testing::sphere_points(points), {}, {});
    return write("sphere.ply", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }

  /// Runs the binary with standard output and error in files; measures processor time and peak memory.
  Ran run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), SURFACED_BINARY);
    std::vector<char*> argv;
    for (std::string& each : arguments) argv.push_back(each.data());
    argv.push_back(nullptr);
    const pid_t child = ::fork();
    if (child == 0) {
      ::dup2(::open((folder_ / "out").c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600), STDOUT_FILENO);
      ::dup2(::open((folder_ / "err").c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600), STDERR_FILENO);
      ::execv(SURFACED_BINARY, argv.data());
      ::_exit(127);
    }
    int status = 0;
    rusage usage{};
    ::wait4(child, &status, 0, &usage);
    Ran ran;
    ran.seconds = testing::processor_seconds(usage);
    ran.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    ran.out = read_all(folder_ / "out");
    ran.err = read_all(folder_ / "err");
    ran.peak_megabytes = static_cast<double>(usage.ru_maxrss) / 1024;
    return ran;
  }

  Ran reconstruct(const std::filesystem::path& cloud, const std::string& mesh = "m.glb") const {
    return run({"reconstruct", cloud, "-o", folder_ / mesh, "--method", "advancing-front"});
  }

  /// The one problem on stderr.
  static nlohmann::json problem(const Ran& ran) { return nlohmann::json::parse(ran.err); }

  std::filesystem::path folder_;
};

}  // namespace surfaced::testing
