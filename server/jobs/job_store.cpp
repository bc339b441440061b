// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/job_store.hpp"

namespace surfaced {

Status Allowance::check(const Holding& holding, std::uint64_t jobs, std::uint64_t more_bytes) const {
  if (active_jobs != 0 && jobs > 0 &&
      (holding.active_jobs >= active_jobs || active_jobs - holding.active_jobs < jobs)) {
    return Error{ErrorCode::quota_exceeded, std::to_string(holding.active_jobs) +
                                                " jobs of the key wait or run, the limit is " +
                                                std::to_string(active_jobs)};
  }
  if (bytes == 0 || (holding.bytes <= bytes && bytes - holding.bytes >= more_bytes)) return Done{};
  return Error{ErrorCode::quota_exceeded, "the key holds " + std::to_string(holding.bytes) + " bytes and sends " +
                                              std::to_string(more_bytes) + ", the limit is " + std::to_string(bytes)};
}

}  // namespace surfaced
