// SPDX-License-Identifier: GPL-3.0-or-later
// What the server and the child of an attempt say to each other: the server gives one JSON object on
// the command line, the child answers with JSON lines on descriptor 3. The server believes nothing
// that comes back: lines are capped, unknown ones dropped.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <variant>

#include "base/base.hpp"
#include "jobs/job.hpp"

namespace surfaced {

/// Descriptor of the child's end of the pipe.
inline constexpr int kMessageDescriptor = 3;
/// A longer line is dropped.
inline constexpr std::size_t kMaxMessageBytes = 8192;

/// What one attempt may use.
struct AttemptLimits {
  std::uint64_t memory_bytes = 0;
  std::uint64_t max_points = 0;
  /// Size of any file it writes, and of all that lie in its directory at a time.
  std::uint64_t file_bytes = 0;
  std::chrono::seconds time{};
  unsigned threads = 1;
  /// What is to stay free of the disk; the server alone looks at it.
  std::uint64_t minimum_free = 0;
};

// nlohmann declares its move noexcept; the analyzer follows its assertions.
// NOLINTNEXTLINE(bugprone-exception-escape)
struct AttemptSpec {
  Claim claim;
  std::string method;
  nlohmann::ordered_json parameters;
  std::filesystem::path cloud;
  /// Of the file; the report names it.
  std::string cloud_sha256;
  /// Where the child writes report.json and the mesh, in the format of its name.
  std::filesystem::path directory;
  std::string mesh;
  /// Where in the directory the method's cloud goes; empty if the job does not want it.
  std::string points;
  AttemptLimits limits;
  /// The process whose death is the child's.
  int parent = 0;
  /// Trace context of the request, for whoever follows the work; may be empty.
  std::string traceparent{};
  /// Names of further meshes to write, in the formats of their names.
  std::vector<std::string> more_meshes{};
  /// To be watched by a process of its own, so that the server outlives it whatever it does; the server alone looks at
  /// it.
  bool guarded = false;
};

std::string encode(const AttemptSpec& spec);
Result<AttemptSpec> decode_attempt(std::string_view text);

struct ProgressMessage {
  double progress = 0;
  std::string phase;
};
using Message = std::variant<std::monostate, ProgressMessage, Error>;

std::string encode(const ProgressMessage& message);
/// Why the child gives up.
std::string encode(const Error& problem);
/// monostate for anything that is not a message.
Message decode_message(std::string_view line);

/// Cuts what arrives into lines; overlong ones are dropped.
class LineSplitter {
 public:
  template <class Sink>
  void add(std::string_view bytes, const Sink& sink) {
    for (const char each : bytes) {
      if (each == '\n') {
        if (!overlong_) sink(std::string_view(line_));
        line_.clear();
        overlong_ = false;
      } else if (line_.size() < kMaxMessageBytes) {
        line_ += each;
      } else {
        overlong_ = true;
      }
    }
  }

 private:
  std::string line_;
  bool overlong_ = false;
};

}  // namespace surfaced
