// SPDX-License-Identifier: GPL-3.0-or-later
// A table of what our PLY reader and its peers make of damaged files: each in a child process with 4 GiB
// of memory and 10 seconds.
//   build/release/io_hostile_peers
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <vector>

#include "benchmarks/io_peers.hpp"
#include "io/io.hpp"
#include "support/limited_child.hpp"
#include "support/ply_files.hpp"

namespace {

using namespace surfaced;
using namespace surfaced::benchmarks;
using surfaced::testing::ChildRun;

struct Sample {
  std::string what;
  std::string text;
};

std::vector<Sample> samples() {
  const std::string axes = "property float x\nproperty float y\nproperty float z\n";
  const auto header = [&](const std::string& form, const std::string& count) {
    return "ply\nformat " + form + " 1.0\nelement vertex " + count + "\n" + axes + "end_header\n";
  };
  const std::string binary = "binary_little_endian";
  const std::string lists =
      "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uint int vertex_indices\nelement vertex "
      "1\n" +
      axes + "end_header\n";
  return {
      {"empty", ""},
      {"PNG", "\x89PNG\r\n\x1a\n pixels"},
      {"no end of header", "ply\nformat ascii 1.0\nelement vertex 1\n"},
      {"binary, 10 of 20 points", header(binary, "20") + std::string(120, '\0')},
      {"ascii, 1 of 2 points", header("ascii", "2") + "1.5 2.5 3.5\n"},
      {"2^31-1 points, 120 bytes", header(binary, "2147483647") + std::string(120, '\0')},
      {"2^40 points, 120 bytes", header(binary, "1099511627776") + std::string(120, '\0')},
      {"list of 2^32-1 values", lists + std::string(4, '\xff') + std::string(120, '\0')},
      {"row of letters", header("ascii", "2") + "1.5 2.5 3.5\na b c\n"},
      {"row too short", header("ascii", "2") + "1.50 2.5\n3.5 4.5 5.5\n"},
      {"x as a list",
       "ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar float x\nproperty float y\nproperty float "
       "z\nend_header\n1 1 1 1\n"},
      {"CRLF header, binary (valid)", testing::with_crlf(header(binary, "2")) + std::string(24, '\1')},
      {"nan (valid)", header("ascii", "2") + "1 2 nan\n4 5 6\n"},
  };
}

using Reader = std::optional<std::size_t> (*)(const std::string&);

/// 0: refused; 1..98: so many points; 99: more; 100: an exception.
int outcome(Reader reader, const std::string& path) {
  const rlimit memory{std::uint64_t{4} << 30, std::uint64_t{4} << 30};
  ::setrlimit(RLIMIT_AS, &memory);
  ::alarm(10);
  if (std::freopen("/dev/null", "w", stderr) == nullptr) return 100;
  try {
    const std::optional<std::size_t> points = reader(path);
    return points ? static_cast<int>(std::min<std::size_t>(*points, 99)) : 0;
  } catch (const std::exception&) {
    return 100;
  }
}

std::string described(const ChildRun& run) {
  std::string text = run.result < 0      ? "crashed or stopped"
                     : run.result == 0   ? "refused"
                     : run.result == 100 ? "exception"
                                         : "read " + std::to_string(run.result);
  if (run.seconds > 0.5) text += ", " + std::to_string(run.seconds).substr(0, 4) + " s";
  if (run.peak_bytes > (std::uint64_t{100} << 20)) text += ", " + std::to_string(run.peak_bytes >> 20) + " MiB";
  return text;
}

}  // namespace

int main() {
  const std::string path =
      std::filesystem::temp_directory_path() / ("surfaced_hostile_" + std::to_string(::getpid()) + ".ply");
  std::cout << "| file | surfaced | CGAL | Draco |\n|---|---|---|---|\n";
  for (const Sample& sample : samples()) {
    if (!write_file(path, testing::bytes_of(sample.text))) return 1;
    std::cout << "| " << sample.what;
    for (const Reader reader : {read_with_surfaced, read_with_cgal, read_with_draco}) {
      std::cout << " | " << std::flush;  // before the fork, or the child would say it too
      std::cout << described(testing::run_in_child([&] { return outcome(reader, path); }));
    }
    std::cout << " |\n";
  }
  std::filesystem::remove(path);
}
