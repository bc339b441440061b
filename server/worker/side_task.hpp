// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "artifacts/artifact_store.hpp"
#include "worker/attempt_runner.hpp"

namespace surfaced {

/// Work for a child besides the attempts at jobs: reading a stored cloud, encoding a mesh anew. It has the limits and
/// the confinement of an attempt; what it wrote is published under a claim that no job ever gets.
class SideTask {
 public:
  /// @param command  program and arguments that the description is appended to
  SideTask(ArtifactStore& artifacts, std::vector<std::string> command, AttemptLimits limits)
      : artifacts_(artifacts), runner_(std::move(command)), limits_(limits) {}

  struct Order {
    /// Where its files are published.
    Claim place;
    /// What the child reads.
    std::filesystem::path input;
    nlohmann::ordered_json parameters;
    /// The file that the child writes.
    std::string output;
    /// Handed to the child as `extra.json` in its directory; not if empty.
    std::string extra;
  };

  /// Blocks until the child is gone. On an error nothing stays of it.
  Result<Output> run(const Order& order, const StopSignal& stop) const;

 private:
  ArtifactStore& artifacts_;
  AttemptRunner runner_;
  AttemptLimits limits_;
};

/// Name of the file for `Order::extra`.
inline constexpr const char* kExtraFile = "extra.json";

}  // namespace surfaced
