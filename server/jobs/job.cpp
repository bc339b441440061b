// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/job.hpp"

#include <algorithm>
#include <array>

namespace surfaced {
namespace {

constexpr auto kStatusNames =
    std::to_array<std::string_view>({"accepted", "running", "successful", "failed", "dismissed"});
constexpr auto kOutcomeNames =
    std::to_array<std::string_view>({"done", "input_invalid", "method_failed", "out_of_memory", "timed_out", "crashed",
                                     "cancelled", "lost", "drained"});

}  // namespace

std::string_view name_of(JobStatus status) { return kStatusNames.at(static_cast<std::size_t>(status)); }

std::optional<JobStatus> job_status_named(std::string_view name) {
  const auto* found = std::ranges::find(kStatusNames, name);
  if (found == kStatusNames.end()) return std::nullopt;
  return static_cast<JobStatus>(found - kStatusNames.begin());
}

std::string_view name_of(Outcome outcome) { return kOutcomeNames.at(static_cast<std::size_t>(outcome)); }

Verdict judge(Outcome outcome, FailureCounts before) {
  switch (outcome) {
    case Outcome::crashed:
    case Outcome::out_of_memory:
      ++before.failures;
      return {before.failures <= kFailuresAllowed, before, before.failures > kFailuresAllowed};
    case Outcome::lost:
      ++before.losses;
      return {before.losses < kLossesAllowed, before, before.losses >= kLossesAllowed};
    case Outcome::drained:
      return {true, before};
    default:
      return {false, before};
  }
}

Error no_such_job(std::string_view id) {
  std::string text(id.substr(0, 64));
  return with_fault({ErrorCode::job_not_found, "no job has the id '" + text + "'"},
                    {"id", text, "the id of a job, as POST /v1/jobs has given it"});
}

}  // namespace surfaced
