// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/job_events.hpp"

#include <utility>

namespace surfaced {

std::shared_ptr<void> JobEvents::subscribe(std::string_view job, std::function<void()> wake) {
  const std::scoped_lock lock(mutex_);
  const auto place = waiters_.emplace(std::string(job), std::move(wake));
  return {nullptr, [this, place](void*) {
            const std::scoped_lock unlock(mutex_);
            waiters_.erase(place);
          }};
}

void JobEvents::changed(std::string_view job) {
  const std::scoped_lock lock(mutex_);
  const auto [first, last] = waiters_.equal_range(job);
  for (auto each = first; each != last; ++each) each->second();
}

}  // namespace surfaced
