#include "config/settings.hpp"

#include <unistd.h>

#include <algorithm>
#include <thread>

namespace surfaced {

void Settings::resolve() {
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  if (workers == 0) workers = cores;
  if (threads_per_job == 0) threads_per_job = cores;
  if (job_memory == 0) {
    const auto pages = static_cast<std::uint64_t>(std::max(0L, ::sysconf(_SC_PHYS_PAGES)));
    const auto page = static_cast<std::uint64_t>(std::max(0L, ::sysconf(_SC_PAGESIZE)));
    // A small machine with many workers still gets enough for a small cloud.
    job_memory = std::max(pages * page / 4 * 3 / workers, std::uint64_t{512} << 20);
  }
}

}  // namespace surfaced
