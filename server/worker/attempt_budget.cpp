// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/attempt_budget.hpp"

#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <utility>

#include "platform/files.hpp"
#include "worker/confined_work.hpp"
#include "worker/sanitizers.hpp"

namespace surfaced {
namespace {

/// The stack of a thread and its share of the heap.
constexpr std::uint64_t kBytesOfAThread = std::uint64_t{16} << 20;
constexpr std::chrono::milliseconds kShortestLook{20};

double processor_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string whole(double seconds) { return std::to_string(static_cast<std::uint64_t>(std::ceil(seconds))); }

}  // namespace

AttemptBudget::AttemptBudget(const AttemptLimits& limits) : limits_(limits) { most_.bytes = limits.memory_bytes; }

AttemptBudget::~AttemptBudget() {
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  if (watch_.joinable()) watch_.join();
}

Status AttemptBudget::begin(std::string job, const Cost& most) {
  const double allowed = static_cast<double>(limits_.time.count()) * std::max(1U, limits_.threads);
  most_.seconds = std::min(allowed, processor_seconds() + most.seconds);
  most_.bytes = std::min(limits_.memory_bytes, most.bytes + kBytesOfAThread * limits_.threads);
  job_ = std::move(job);
  std::cerr << "at most " << whole(most_.seconds) << " s of processor time and " << most_.bytes << " bytes for " << job_
            << std::endl;
  if (Status limited = limit_memory(); !limited) return limited;
  watch_ = std::thread([this] { watch_time(); });
  return Done{};
}

Status AttemptBudget::limit_memory() {
  if (kSanitized || most_.bytes == limits_.memory_bytes) return Done{};
  const rlimit both{most_.bytes, most_.bytes};
  if (::setrlimit(RLIMIT_DATA, &both) != 0) return system_error("limit the memory", errno);
  return Done{};
}

void AttemptBudget::watch_time() {
  std::unique_lock lock(mutex_);
  while (!ended_) {
    const double left = most_.seconds - processor_seconds();
    if (left <= 0) {
      const Error error{ErrorCode::timed_out, "the work took more than " + whole(most_.seconds) +
                                                  " s of processor time, which is more than any sensible cloud of " +
                                                  job_ + " takes"};
      std::cerr << "problem " << name_of(error.code) << ": " << error.detail << std::endl;
      tell_server(encode(error));
      std::_Exit(exit_code_of(error.code));
    }
    const auto look = std::chrono::milliseconds(static_cast<std::int64_t>(1000 * left / std::max(1U, limits_.threads)));
    changed_.wait_for(lock, std::max(kShortestLook, look));
  }
}

Error AttemptBudget::out_of_memory() const {
  return {ErrorCode::out_of_memory, "an allocation failed; the limit is " + std::to_string(most_.bytes) + " bytes" +
                                        (job_.empty() ? "" : ", for " + job_)};
}

}  // namespace surfaced
