// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/settings.hpp"

#include <unistd.h>

#include <algorithm>
#include <thread>

#include "platform/machine.hpp"

namespace surfaced {

void Settings::resolve() {
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  if (workers == 0) workers = cores;
  if (threads_per_job == 0) threads_per_job = cores;
  // A small machine with many workers still gets enough for a small cloud.
  if (job_memory == 0) job_memory = std::max(machine_memory() / 4 * 3 / workers, std::uint64_t{512} << 20);
}

}  // namespace surfaced
