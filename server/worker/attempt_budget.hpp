// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "reconstruction/reconstruction.hpp"
#include "worker/attempt_protocol.hpp"

namespace surfaced {

/// Holds a child to what a cloud of its size may take with its method, where that is less than the operator's limits:
/// memory by a limit of the process, processor time by a thread that ends the process when it is used up. The server
/// holds the child to the operator's limits whatever happens here.
class AttemptBudget {
 public:
  explicit AttemptBudget(const AttemptLimits& limits);
  ~AttemptBudget();
  AttemptBudget(const AttemptBudget&) = delete;
  AttemptBudget& operator=(const AttemptBudget&) = delete;

  /// Once, when it is known what the job may take. Says in the log what holds.
  /// @param job  for messages: how many points, which method.
  Status begin(std::string job, const Cost& most);

  /// That memory ran out.
  Error out_of_memory() const;

 private:
  Status limit_memory();
  void watch_time();

  AttemptLimits limits_;
  Cost most_{};
  std::string job_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
  std::thread watch_;
};

}  // namespace surfaced
