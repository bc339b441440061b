#pragma once

#include <condition_variable>
#include <mutex>
#include <set>
#include <string>

#include "artifacts/artifact_store.hpp"
#include "jobs/job_store.hpp"
#include "worker/side_task.hpp"

namespace surfaced {

/// Other formats of a job's mesh, made by a child when they are first asked for, and kept with the job's outputs from
/// then on. A format is made once, however many ask for it; a bounded number is made at once.
class Renditions {
 public:
  Renditions(JobStore& jobs, ArtifactStore& artifacts, const SideTask& task)
      : jobs_(jobs), artifacts_(artifacts), task_(task) {}

  /// Blocks until the output is there.
  /// @param number  of the format; two formats of a job have different ones
  /// @return  not_ready if others are made and it is nobody's turn for long; job_gone; what the child says.
  Result<Output> make(const Job& job, const std::string& name, std::uint32_t number);

  /// Ends the children that may be running, and refuses from then on.
  void stop();

 private:
  /// Made meanwhile by somebody else, or made now.
  Result<Output> make_alone(const std::string& job, const std::string& name, std::uint32_t number);

  JobStore& jobs_;
  ArtifactStore& artifacts_;
  const SideTask& task_;
  StopSignal stop_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::string> running_;
};

}  // namespace surfaced
