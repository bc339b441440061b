#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>

namespace surfaced {

/// Wakes those who wait for a job in this process. It only says that something changed; what, the
/// store knows. A waiter subscribes before it looks at the job, so that no change falls between.
class JobEvents {
 public:
  class Subscription {
   public:
    Subscription(JobEvents& events, std::string_view job);
    ~Subscription();
    Subscription(const Subscription&) = delete;
    Subscription& operator=(const Subscription&) = delete;

    /// Waits for a change since the subscription or the last call; false when the time is over or the
    /// server stops.
    bool wait_until(std::chrono::steady_clock::time_point deadline);

   private:
    JobEvents& events_;
    std::string job_;
    std::uint64_t seen_ = 0;
  };

  void changed(std::string_view job);

  /// Ends all waiting, now and later.
  void close();

 private:
  struct Topic {
    std::uint64_t version = 0;
    std::size_t waiters = 0;
    std::condition_variable changed;
  };
  std::mutex mutex_;
  std::unordered_map<std::string, Topic> topics_;
  bool closed_ = false;
};

}  // namespace surfaced
