// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace surfaced::sqlite {

/// A mutex that is waited for no longer than one likes. Not std::timed_mutex: the thread sanitizer of GCC 12 does not
/// know pthread_mutex_clocklock and would be blind to everything under it.
class PatientMutex {
 public:
  bool try_lock_for(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!free_.wait_for(lock, patience, [&] { return !taken_; })) return false;
    taken_ = true;
    return true;
  }
  void unlock() {
    const std::scoped_lock lock(mutex_);
    taken_ = false;
    free_.notify_one();
  }

 private:
  std::mutex mutex_;
  std::condition_variable free_;
  bool taken_ = false;
};

}  // namespace surfaced::sqlite
