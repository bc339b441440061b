// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <set>
#include <string>

#include "artifacts/artifact_store.hpp"
#include "jobs/job_store.hpp"

namespace surfaced {

/// Finds files that no job refers to while the service runs. A file is removed only if the job store did not know
/// it at two looks, each of which listed the files before it asked: what is on its way between the two stores
/// (an upload that is about to become a job, outputs that are about to be settled) is known at the second one.
/// If the job store cannot be asked, nothing is removed.
class OrphanSweep {
 public:
  OrphanSweep(JobStore& jobs, ArtifactStore& artifacts) : jobs_(jobs), artifacts_(artifacts) {}

  /// One look; to be called with minutes between.
  /// @return  how much was removed
  Result<std::size_t> look();

 private:
  JobStore& jobs_;
  ArtifactStore& artifacts_;
  std::set<std::string> suspects_;
};

}  // namespace surfaced
